#include "cli/chaos/stranger.hpp"

#include <algorithm>
#include <limits>
#include <memory>
#include <type_traits>

#include "controller/base/time.hpp"

namespace c3rt::cli::chaos {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr int kMostAtOnce = 1000;  // after a stall of this process

// Valid, and felt at once if it were obeyed.
void mislead(wire::RobotState& sample) { sample.q_rad[0] += 0.1; }
void mislead(wire::RobotCommand& sample) { sample.tau_nm[0] += 5.0; }
void mislead(wire::Plan& sample) {
  for (int i = 0; i < sample.knot_count; ++i) sample.knots[i].p_WE_m[0] += 0.05;
}
void mislead(wire::ObjectEstimate& sample) { sample.p_WB_m[0] += 0.05; }

// What no process grants.
void spoil(wire::TaskTarget& sample) { sample.parameter_count = -1; }
void spoil(wire::FaultInject& sample) { sample.duration_s = kNan; }

/// How many of `rate` a second are due at `now_ns`.
class Due {
 public:
  explicit Due(double rate) : rate_(rate) {}
  int take(std::int64_t now_ns) {
    if (last_ns_ == 0) last_ns_ = now_ns;
    owed_ = std::min(owed_ + base::seconds(now_ns - last_ns_) * rate_, double{kMostAtOnce});
    last_ns_ = now_ns;
    const int whole = static_cast<int>(owed_);
    owed_ -= whole;
    return whole;
  }

 private:
  double rate_, owed_ = 0.0;
  std::int64_t last_ns_ = 0;
};

/// What it hears of the topic, misled, at `rate` a second.
template <typename T>
std::function<void(std::int64_t)> doubled(wire::Bus& bus, double rate) {
  struct Double {
    Double(wire::Bus& its_bus, double its_rate) : reader(its_bus), writer(its_bus), due(its_rate) {}
    wire::Reader<T> reader;
    wire::Writer<T> writer;
    Due due;
    T heard{};
  };
  const auto self = std::make_shared<Double>(bus, rate);
  return [self](std::int64_t now_ns) {
    self->reader.take_newest(self->heard);
    const int count = self->due.take(now_ns);
    if (self->heard.header.seq == 0) return;
    for (int i = 0; i < count; ++i) {
      T sample = self->heard;
      mislead(sample);
      self->writer.write(sample, now_ns);
    }
  };
}

/// Requests that nobody can grant, at `rate` a second.
template <typename T>
std::function<void(std::int64_t)> flood(wire::Bus& bus, double rate, T refused) {
  struct Flood {
    Flood(wire::Bus& its_bus, double its_rate) : writer(its_bus), due(its_rate) {}
    wire::Writer<T> writer;
    Due due;
  };
  const auto self = std::make_shared<Flood>(bus, rate);
  return [self, refused](std::int64_t now_ns) {
    const int count = self->due.take(now_ns);
    for (int i = 0; i < count; ++i) {
      T sample = refused;
      if (!self->writer.write(sample, now_ns)) return;  // readers that are full set the pace
    }
  };
}

std::function<void(std::int64_t)> speech(wire::Bus& bus, const Fault& fault) {
  std::function<void(std::int64_t)> speak;
  wire::with_topic(fault.target, [&](const auto& sample) {
    using T = std::decay_t<decltype(sample)>;
    constexpr bool can_mislead =
        std::is_same_v<T, wire::RobotState> || std::is_same_v<T, wire::RobotCommand> ||
        std::is_same_v<T, wire::Plan> || std::is_same_v<T, wire::ObjectEstimate>;
    if constexpr (can_mislead) {
      speak = doubled<T>(bus, fault.amount);
    } else if constexpr (std::is_same_v<T, wire::TaskTarget> ||
                         std::is_same_v<T, wire::FaultInject>) {
      T refused{};
      spoil(refused);
      speak = flood<T>(bus, fault.amount, refused);
    }
  });
  return speak;
}

}  // namespace

const std::vector<std::string_view>& doubled_topics() {
  static const std::vector<std::string_view> all{
      wire::topic<wire::RobotState>().name, wire::topic<wire::RobotCommand>().name,
      wire::topic<wire::Plan>().name, wire::topic<wire::ObjectEstimate>().name};
  return all;
}

const std::vector<std::string_view>& flooded_topics() {
  static const std::vector<std::string_view> all{wire::topic<wire::TaskTarget>().name,
                                                 wire::topic<wire::FaultInject>().name};
  return all;
}

Stranger::Stranger(wire::Bus& bus, const Fault& fault) : speak_(speech(bus, fault)) {}

}  // namespace c3rt::cli::chaos
