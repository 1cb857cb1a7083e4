#include "cli/chaos/lines.hpp"

#include <algorithm>
#include <functional>
#include <limits>
#include <memory>

#include "controller/base/time.hpp"

namespace c3rt::cli::chaos {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr std::int64_t kEcho_ns = 5'000'000;  // a duplicate comes so much later, every second one

// a number that its reader uses
void spoil(wire::RobotState& sample) { sample.q_rad[0] = kNan; }
void spoil(wire::RobotCommand& sample) { sample.tau_nm[0] = kNan; }
void spoil(wire::Plan& sample) { sample.knots[0].p_WE_m[0] = kNan; }
void spoil(wire::ObjectEstimate& sample) { sample.p_WB_m[0] = kNan; }
void spoil(wire::Scene& sample) { sample.objects[0].p_WB_m[0] = kNan; }

// the stamps that a writer's own clock gave
void shift(std::int64_t& stamp, std::int64_t by) {
  if (stamp != 0) stamp = std::max<std::int64_t>(stamp + by, 1);
}
template <typename T>
void shift_clock(T& sample, std::int64_t by) {
  shift(sample.header.time_ns, by);
}
void shift_clock(wire::ObjectEstimate& sample, std::int64_t by) {
  shift(sample.header.time_ns, by);
  shift(sample.exposure_ns, by);
}
void shift_clock(wire::Plan& sample, std::int64_t by) {
  shift(sample.header.time_ns, by);
  shift(sample.valid_until_ns, by);
  for (int i = 0; i < sample.knot_count; ++i) shift(sample.knots[i].time_ns, by);
}

template <typename T>
void shift_object(T&, double, double) {}
void shift_object(wire::ObjectEstimate& sample, double x, double y) {
  sample.p_WB_m[0] += x;
  sample.p_WB_m[1] += y;
}

template <typename T>
std::function<wire::Passage(T&)> line_of(const Fault& fault) {
  const auto random = std::make_shared<base::Random>(fault.seed);
  const double amount = fault.amount;
  const std::int64_t time_ns = base::nanoseconds(amount);
  switch (fault.kind->act) {
    case Act::kDelay:
      return [time_ns](T&) { return wire::Passage{1, time_ns}; };
    case Act::kDrop:
      return [=](T&) { return wire::Passage{random->uniform() < amount ? 0 : 1, 0}; };
    case Act::kDuplicate:
      return [=](T&) {
        // at once, or after others
        const bool twice = random->uniform() < amount, late = random->uniform() < 0.5;
        return wire::Passage{twice ? 2 : 1, twice && late ? kEcho_ns : 0};
      };
    case Act::kReorder:
      return [=](T&) { return wire::Passage{1, base::nanoseconds(amount * random->uniform())}; };
    case Act::kSpoil:
      return [=](T& sample) {
        if (random->uniform() < amount) spoil(sample);
        return wire::Passage{};
      };
    case Act::kShiftClock:
      return [time_ns](T& sample) {
        shift_clock(sample, time_ns);
        return wire::Passage{};
      };
    case Act::kShiftObject: {
      const double angle = 2.0 * M_PI * random->uniform();
      return [=](T& sample) {
        shift_object(sample, amount * std::cos(angle), amount * std::sin(angle));
        return wire::Passage{};
      };
    }
    case Act::kKill:
    case Act::kKillService:
    case Act::kStop:
    case Act::kInject:
    case Act::kDouble:
    case Act::kFlood:
    case Act::kFillDisk:
      break;
  }
  return {};
}

/// Calls `action` with a sample of the edge's type.
template <typename Action>
void with_type(const Edge& edge, Action&& action) {
  wire::with_topic(edge.topic->name, [&](const auto& sample) {
    using T = std::decay_t<decltype(sample)>;
    constexpr bool is_line =
        std::is_same_v<T, wire::RobotState> || std::is_same_v<T, wire::RobotCommand> ||
        std::is_same_v<T, wire::Plan> || std::is_same_v<T, wire::ObjectEstimate> ||
        std::is_same_v<T, wire::Scene>;
    if constexpr (is_line) action(sample);
  });
}

}  // namespace

const Edge* edge_of(std::string_view name) {
  const auto found = std::find_if(edges().begin(), edges().end(),
                                  [name](const Edge& edge) { return edge.name == name; });
  return found == edges().end() ? nullptr : &*found;
}

void set_line(wire::Exchange& exchange, const Fault& fault, std::uint64_t bus) {
  with_type(*edge_of(fault.target), [&](const auto& sample) {
    using T = std::decay_t<decltype(sample)>;
    exchange.set_line<T>(bus, line_of<T>(fault));
  });
}

void clear_line(wire::Exchange& exchange, const Fault& fault, std::uint64_t bus) {
  with_type(*edge_of(fault.target), [&](const auto& sample) {
    exchange.set_line<std::decay_t<decltype(sample)>>(bus, {});
  });
}

}  // namespace c3rt::cli::chaos
