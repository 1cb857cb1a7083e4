#include "cli/view.hpp"

#include <nlohmann/json.hpp>

namespace c3rt::cli {

int view(const Seat& seat, const ViewSettings& settings) {
  become_python(seat, "c3rt.view", "view", {"viser", "cyclonedds"},
                shown_scene(seat, settings.shown),
                {"--host", settings.host, "--port", std::to_string(settings.port)});
}

}  // namespace c3rt::cli
