#include "cli/replay/publisher.hpp"

#include <algorithm>
#include <chrono>
#include <thread>
#include <type_traits>

#include <fmt/format.h>

#include "cli/recording/in_order.hpp"
#include "cli/replay/rebase.hpp"
#include "controller/base/time.hpp"
#include "controller/rt/periodic_clock.hpp"
#include "idl/process.hpp"

namespace c3rt::cli::replay {
namespace {

using base::seconds;

constexpr std::int64_t kNap_ns = 50'000'000;       // so soon a stop is seen
constexpr std::int64_t kWorthIt_ns = 200'000;      // less is not slept
constexpr std::int64_t kWatch_ns = 1'000'000'000;  // between two looks at who else writes

}  // namespace

Publisher::Publisher(wire::Bus& bus, const std::set<std::string>& topics, double rate,
                     std::int64_t begin_ns, std::int64_t end_ns)
    : rate_(rate), begin_ns_(begin_ns), end_ns_(end_ns) {
  wire::for_each_topic([&](const auto& kind) {
    using T = std::decay_t<decltype(kind)>;
    if (topics.count(wire::topic<T>().name) > 0)
      std::get<std::unique_ptr<wire::Writer<T>>>(writers_) = std::make_unique<wire::Writer<T>>(bus);
  });
}

void Publisher::begin() { began_ns_ = looked_ns_ = rt::now_ns(); }

double Publisher::passed() const { return seconds(std::max(time_ns_, begin_ns_) - begin_ns_); }

bool Publisher::has_enough() const { return wire::StopFlag::requested() || !failure_.empty(); }

void Publisher::at(std::int64_t time_ns) {
  time_ns_ = time_ns;
  std::int64_t now_ns = rt::now_ns();
  due_ns_ = now_ns;
  if (rate_ > 0.0) {
    due_ns_ =
        began_ns_ + static_cast<std::int64_t>(static_cast<double>(time_ns - begin_ns_) / rate_);
    while (due_ns_ - now_ns > kWorthIt_ns && !wire::StopFlag::requested()) {
      std::this_thread::sleep_for(std::chrono::nanoseconds(std::min(due_ns_ - now_ns, kNap_ns)));
      now_ns = rt::now_ns();
    }
    latest_ = std::max(latest_, seconds(now_ns - due_ns_));
  }
  if (watch_ && now_ns - looked_ns_ > kWatch_ns) {
    looked_ns_ = now_ns;
    failure_ = watch_();
  }
  const double whole = std::max(seconds(end_ns_ - begin_ns_), 1e-9);
  if (progress_)
    progress_->update(std::min(passed() / whole, 1.0),
                      fmt::format("{:.1f} of {:.1f} s", passed(), whole));
}

template <typename T>
void Publisher::publish(const T& recorded) {
  const auto& writer = std::get<std::unique_ptr<wire::Writer<T>>>(writers_);
  if (writer == nullptr || has_enough()) return;
  T sample = recorded;
  // another's time, or that of long ago, is as good as now
  const std::int64_t from_ns = keeps_time(wire::topic<T>()) ? sample.header.time_ns : time_ns_;
  Rebase rebase(from_ns, due_ns_, rate_ > 0.0 ? rate_ : 1.0);
  rebase(sample);
  // numbers that name samples of other topics: those count from 1, too
  const auto renumber = [](std::uint64_t& seq, const Numbers& of) {
    if (seq != 0 && of.written != 0) seq += of.written - of.recorded;
  };
  if constexpr (std::is_same_v<T, wire::PlannerDebug>) renumber(sample.plan_seq, plans_);
  if constexpr (std::is_same_v<T, wire::RobotState>) renumber(sample.command_seq, commands_);
  if (!writer->write(sample, due_ns_)) {
    ++not_sent_;
    return;
  }
  if constexpr (std::is_same_v<T, wire::Plan>) plans_ = {recorded.header.seq, sample.header.seq};
  if constexpr (std::is_same_v<T, wire::RobotCommand> || std::is_same_v<T, wire::RobotMotion>)
    commands_ = {recorded.header.seq, sample.header.seq};
  ++written_[wire::topic<T>().name];
}

#define C3RT_TOPIC(Type, ...) \
  void Publisher::hear(const wire::Type& sample) { publish(sample); }
C3RT_TOPICS(C3RT_TOPIC)
#undef C3RT_TOPIC

}  // namespace c3rt::cli::replay
