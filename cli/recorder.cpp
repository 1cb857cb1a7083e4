#include "cli/recorder.hpp"

#include <chrono>
#include <memory>
#include <tuple>
#include <type_traits>
#include <vector>

#include <fmt/format.h>

#include "cli/log.hpp"
#include "controller/base/time.hpp"
#include "controller/rt/periodic_clock.hpp"
#include "idl/process.hpp"
#include "idl/text.hpp"

namespace c3rt::cli {
namespace {

constexpr int kDepth = 1024;    // a second of the fastest topic may wait until it is taken
constexpr double kStep = 1e-3;  // of the plant [s]

using base::seconds;

Eigen::Vector3d vector(const c3rt_v2_Vec3& value) { return {value[0], value[1], value[2]}; }

SceneRow row_of(const wire::Scene& sample) {
  SceneRow row;
  row.time_ns = sample.header.time_ns;
  row.exposure = sample.exposure;
  row.object_count = std::min(static_cast<int>(sample.object_count), kMaxObjects);
  for (std::size_t i = 0; i < static_cast<std::size_t>(row.object_count); ++i) {
    const double(&q)[4] = sample.objects[i].q_WB;
    row.p_WB[i] = vector(sample.objects[i].p_WB_m);
    row.q_WB[i] = Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
  }
  return row;
}

StateRow row_of(const wire::RobotState& sample) {
  return {sample.header.time_ns, sample.header.seq,
          vector(sample.p_WE_m), sample.mode == c3rt_v2_ROBOT_REFLEX,
          sample.errors,         sample.command_success_rate};
}

CommandRow row_of(const wire::RobotCommand& sample) {
  return {sample.header.time_ns,
          sample.origin.state_ns,
          sample.origin.exposure_ns,
          sample.origin.plan_ns,
          sample.mode == c3rt_v2_IMPEDANCE_TRACK,
          vector(sample.p_WE_desired_m)};
}

PlanRow row_of(const wire::Plan& sample) {
  return {sample.header.time_ns,
          sample.origin.state_ns,
          sample.origin.exposure_ns,
          wire::is_at_task(sample.phase),
          sample.status == c3rt_v2_PLAN_TRUNCATED,
          sample.status == c3rt_v2_PLAN_FALLBACK,
          sample.solve_time_s};
}

EstimateRow row_of(const wire::ObjectEstimate& sample) {
  const double(&q)[4] = sample.q_measured;
  return {sample.header.time_ns,
          sample.exposure_ns,
          static_cast<int>(sample.object_index),
          sample.valid,
          sample.sensors_used,
          vector(sample.p_measured_m),
          Eigen::Quaterniond(q[0], q[1], q[2], q[3])};
}

}  // namespace

double wall_time() { return seconds(rt::now_ns()); }

namespace {

/// What the report needs of a sample.
template <typename T>
void keep(const T&, Series&) {}  // nothing
void keep(const wire::Scene& sample, Series& series) { series.scene.push_back(row_of(sample)); }
void keep(const wire::RobotState& sample, Series& series) {
  series.state.push_back(row_of(sample));
}
void keep(const wire::RobotCommand& sample, Series& series) {
  series.command.push_back(row_of(sample));
}
void keep(const wire::Plan& sample, Series& series) { series.plan.push_back(row_of(sample)); }
void keep(const wire::ObjectEstimate& sample, Series& series) {
  series.estimate.push_back(row_of(sample));
}

/// What a listener hears of the streams.
template <typename T>
constexpr bool kHeard =
    std::is_same_v<T, wire::Plan> || std::is_same_v<T, wire::Scene> ||
    std::is_same_v<T, wire::ObjectEstimate> || std::is_same_v<T, wire::RobotState> ||
    std::is_same_v<T, wire::RobotCommand>;

/// A topic on its way from the bus to its log.
template <typename T>
struct Recorded {
  Recorded(wire::Bus& bus, const std::filesystem::path& directory)
      : reader(bus, kDepth), log(directory) {}
  /// @param series nullptr: nothing is kept
  void drain(Series* series, Listener* listener) {
    while (reader.take(newest)) {
      any = true;
      if constexpr (kHeard<T>) {
        if (listener != nullptr) listener->hear(newest);
      }
      if (series == nullptr) continue;
      log.add(newest);
      keep(newest, *series);
    }
  }
  wire::Reader<T> reader;
  TopicLog<T> log;
  T newest{};
  bool any = false;
};

template <typename Types>
struct RecordedTopics;
/// Every topic that is a stream.
template <typename... T>
struct RecordedTopics<std::tuple<T...>> {
  RecordedTopics(wire::Bus& bus, const std::filesystem::path& directory) {
    ((recorded<T>(bus, directory)), ...);
  }
  template <typename Action>
  void for_each(Action&& action) {
    std::apply([&action](auto&... topic) { ((topic != nullptr ? action(*topic) : void()), ...); },
               all_);
  }
  template <typename U>
  Recorded<U>& of() {
    return *std::get<std::unique_ptr<Recorded<U>>>(all_);
  }

 private:
  template <typename U>
  void recorded(wire::Bus& bus, const std::filesystem::path& directory) {
    if (wire::topic<U>().stream == wire::kNoStream) return;
    std::get<std::unique_ptr<Recorded<U>>>(all_) = std::make_unique<Recorded<U>>(bus, directory);
  }
  std::tuple<std::unique_ptr<Recorded<T>>...> all_;
};

}  // namespace

struct Recorder::Topics {
  Topics(wire::Bus& bus, const std::filesystem::path& directory, const task::Task& task)
      : recorded(bus, directory), status(bus, 64), course(task) {}

  /// Takes all that has come.
  void drain(Series* series, Listener* listener) {
    recorded.for_each([](auto& topic) { topic.any = false; });
    // a command may follow a plan that has just come
    recorded.of<wire::Plan>().drain(series, listener);
    recorded.for_each([&](auto& topic) { topic.drain(series, listener); });
  }

  void finish() {
    recorded.for_each([](auto& topic) { topic.log.finish(); });
  }

  HashVisitor hash() {
    HashVisitor all;
    recorded.for_each([&all](auto& topic) { all("", topic.log.hash()); });
    return all;
  }

  RecordedTopics<wire::TopicTypes> recorded;
  wire::Reader<wire::ServiceStatus> status;
  Course course;
  std::optional<std::int64_t> task_start;  // as task_start_ns() [ns]
  std::size_t judged = 0;                  // states looked at for a reflex
  std::int64_t reflex_since = 0;           // 0: the robot is in none [ns]
  std::size_t counted = 0;                 // rows of the scene that the course has seen
  double wall_first = 0.0, wall_last = 0.0;
  std::uint64_t seq_first = 0, seq_last = 0;
};

struct Recorder::Seat {
  Seat(const wire::BusSettings& settings, const std::filesystem::path& directory,
       const task::Task& task)
      : bus(settings), topics(bus, directory, task) {
    bus.hold_until_promised();
  }
  wire::Bus bus;
  Topics topics;
};

Recorder::Recorder(const wire::BusSettings& bus, const std::filesystem::path& directory,
                   const Goal& goal, const std::filesystem::path& scratch, Listener* listener)
    : settings_(bus), directory_(directory), goal_(goal), listener_(listener), series_(scratch) {
  if (!directory_.empty()) std::filesystem::create_directories(directory_);
  if (bus.exchange != nullptr) {
    seat_ = std::make_unique<Seat>(settings_, directory_, goal_.task);
  } else {
    thread_ = std::thread([this] { run(); });
  }
}

Recorder::~Recorder() { stop(); }

void Recorder::stop() {
  stop_.store(true);
  if (seat_ != nullptr) {
    {
      const std::lock_guard lock(mutex_);
      take_words(seat_->topics);  // the last ones
    }
    finish(seat_->topics);
    seat_.reset();
  }
  if (!thread_.joinable()) return;
  // in lockstep the thread may be waiting for a tick that never comes
  if (settings_.clock == wire::ClockMode::kLockstep) wire::StopFlag::request();
  thread_.join();
}

std::string Recorder::failure() const {
  const std::lock_guard lock(mutex_);
  return failure_;
}

Live Recorder::live() const {
  const std::lock_guard lock(mutex_);
  return live_;
}

void Recorder::run() noexcept {
  try {
    record();
  } catch (const std::exception& error) {
    const std::lock_guard lock(mutex_);
    failure_ = error.what();
  }
}

void Recorder::record() {
  wire::Bus bus(settings_);
  Topics topics(bus, directory_, goal_.task);
  if (settings_.clock == wire::ClockMode::kLockstep) {
    wire::Loop loop(bus, {c3rt_v2_PROCESS_RECORDER, kPeriod_ns});
    std::int64_t now_ns = 0;
    while (!stop_.load() && !done_.load() && loop.wait(now_ns)) {
      if (take_all(topics, bus)) done_.store(true);
    }
    const std::lock_guard lock(mutex_);
    failure_ = loop.failure();
  } else {
    // waking for every sample would cost a tenth of a core; the readers are deep enough to look now
    // and then
    while (!stop_.load() && (!done_.load() || listener_ != nullptr)) {
      forget(topics);
      if (done_.load()) {
        look_on(topics, bus);
      } else if (take_all(topics, bus)) {
        done_.store(true);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }
  finish(topics);
}

void Recorder::begin_again(const Goal& goal) {
  const std::lock_guard lock(mutex_);
  next_goal_ = goal;
}

void Recorder::forget(Topics& topics) {
  {
    const std::lock_guard lock(mutex_);
    if (!next_goal_) return;
    goal_ = *next_goal_;
    next_goal_.reset();
    live_.any = live_.rolling = live_.robot_stopped = false;
    live_.time = live_.turns = 0.0;
    live_.loops = 0;
    live_.object_error = kNone;
  }
  series_ = Series(series_.folder);
  topics.course = Course(goal_.task);
  topics.task_start.reset();
  topics.judged = topics.counted = 0;
  topics.reflex_since = 0;
  done_.store(false);
}

void Recorder::look_on(Topics& topics, const wire::Bus& bus) {
  topics.drain(nullptr, listener_);
  std::vector<wire::RefusedCount> refused = bus.refusals();
  const std::lock_guard lock(mutex_);
  live_.refused = std::move(refused);
  take_words(topics);
  live_.steps = topics.recorded.of<wire::RobotState>().newest.header.seq;
  live_.plan = topics.recorded.of<wire::Plan>().newest;
}

void Recorder::finish(Topics& topics) {
  topics.finish();
  log_hash_ = topics.hash().text();
  if (topics.wall_last > topics.wall_first) {
    real_time_factor_ = static_cast<double>(topics.seq_last - topics.seq_first) * kStep /
                        (topics.wall_last - topics.wall_first);
  }
}

void Recorder::take(const wire::Sequences& newest) {
  std::string missing;
  if (!seat_->bus.wait_for(newest, 0, missing))
    throw wire::WireError("recorder: a sample of " + missing + " did not arrive");
  if (take_all(seat_->topics, seat_->bus)) done_.store(true);
}

void Recorder::take_words(Topics& topics) {
  wire::ServiceStatus status{};
  while (topics.status.take(status)) {
    const auto process = static_cast<std::size_t>(status.process);
    if (process < live_.services.size()) live_.services[process] = status;
    if (listener_ != nullptr) listener_->hear(status);
  }
}

bool Recorder::take_all(Topics& topics, const wire::Bus& bus) {
  const std::size_t plans_before = series_.plan.size();
  topics.drain(&series_, listener_);
  if (topics.recorded.of<wire::RobotState>().any) {
    topics.wall_last = wall_time();
    topics.seq_last = series_.state.back().seq;
    if (topics.wall_first == 0.0) {
      topics.wall_first = topics.wall_last;
      topics.seq_first = topics.seq_last;
    }
  }
  for (; topics.judged < series_.state.size(); ++topics.judged) {
    const StateRow& row = series_.state[topics.judged];
    if (!row.reflex) {
      topics.reflex_since = 0;
    } else if (topics.reflex_since == 0) {
      topics.reflex_since = row.time_ns;
    }
  }
  const bool gave_up =
      topics.reflex_since != 0 && !series_.state.empty() &&
      seconds(series_.state.back().time_ns - topics.reflex_since) > goal_.reflex_patience;
  for (std::size_t i = plans_before; i < series_.plan.size() && !topics.task_start; ++i) {
    if (series_.plan[i].rolling) topics.task_start = series_.plan[i].state_ns;
  }

  // the same count as evaluate(): scenes from the first plan that rolls
  for (; topics.counted < series_.scene.size() && topics.task_start; ++topics.counted) {
    const SceneRow& row = series_.scene[topics.counted];
    if (row.time_ns >= *topics.task_start)
      topics.course.add(seconds(row.time_ns - *topics.task_start), row);
  }

  std::vector<wire::RefusedCount> refused = bus.refusals();
  const std::lock_guard lock(mutex_);
  live_.refused = std::move(refused);
  take_words(topics);
  if (topics.recorded.of<wire::Scene>().any) {
    live_.any = true;
    live_.time = seconds(series_.scene.back().time_ns - start_ns(series_));
    const SceneRow& row = series_.scene.back();
    const double elapsed = topics.task_start ? seconds(row.time_ns - *topics.task_start) : 0.0;
    live_.object_error = worst_error(goal_.task, elapsed, row);
  }
  const auto& plans = topics.recorded.of<wire::Plan>();
  if (plans.any) live_.plan = plans.newest;
  live_.rolling = topics.task_start.has_value();
  live_.turns = topics.course.progress().amount();
  live_.loops = topics.course.progress().completed();
  live_.steps = topics.seq_last;
  live_.robot_stopped = gave_up;
  return gave_up || topics.course.progress().completed() >= goal_.loops ||
         live_.time >= goal_.duration;
}

}  // namespace c3rt::cli
