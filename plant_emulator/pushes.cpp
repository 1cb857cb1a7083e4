#include "plant_emulator/pushes.hpp"

#include <algorithm>

#include "plant_emulator/draws.hpp"

namespace c3rt::plant {
namespace {

// the start of the objects is drawn from the same seed and shall not be the same numbers
constexpr std::uint64_t kStream = 0x9E3779B97F4A7C15;

}  // namespace

std::vector<Push> drawn_pushes(const PushParameters& parameters, int objects, std::uint64_t seed) {
  base::Random random(seed ^ kStream);
  const double piece = (parameters.until - parameters.from) / std::max(1, parameters.count);
  std::vector<Push> pushes;
  for (int i = 0; i < parameters.count; ++i) {
    Push push{};
    push.time = parameters.from + piece * (i + 0.5 * random.uniform());
    push.object = std::min(static_cast<int>(objects * random.uniform()), objects - 1);
    const double size = parameters.impulse_min +
                        (parameters.impulse_max - parameters.impulse_min) * random.uniform();
    push.impulse << size * draw_direction(random), 0.0;
    pushes.push_back(push);
  }
  return pushes;
}

}  // namespace c3rt::plant
