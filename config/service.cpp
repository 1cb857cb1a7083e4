#include "config/service.hpp"

namespace c3rt::config {

Service load_service(Section& root) {
  if (root.has("example")) {
    root.fail("example", "no such key: a numerical example has none of the four processes",
              root.text("example") + " (c3rt run runs it)");
  }
  Service service{Recovery::kAutomatic};
  if (!root.has("service")) return service;
  Section section = root.section("service");
  service.recovery = section.choice<Recovery>(
      "recovery", {{"automatic", Recovery::kAutomatic}, {"by_person", Recovery::kByPerson}});
  section.finish();
  return service;
}

}  // namespace c3rt::config
