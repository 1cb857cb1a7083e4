#include "cli/recorder.hpp"

#include <chrono>
#include <memory>
#include <tuple>
#include <type_traits>
#include <vector>

#include <fmt/format.h>

#include "controller/base/time.hpp"
#include "controller/rt/periodic_clock.hpp"
#include "idl/process.hpp"
#include "idl/text.hpp"

namespace c3rt::cli {
namespace {

constexpr double kStep = 1e-3;  // of the plant [s]

using base::seconds;

}  // namespace

double wall_time() { return seconds(rt::now_ns()); }

struct Recorder::Topics {
  Topics(wire::Bus& bus, const task::Task& task) : taken(bus), course(task) {}

  /// Takes all that has come, but for the words of the processes.
  void drain(const Takers& takers) {
    taken.for_each([](auto& topic) { topic.any = false; });
    // a command may follow a plan that has just come
    taken.of<wire::Plan>().drain(takers);
    taken.for_each([&](auto& topic) {
      if constexpr (!std::is_same_v<decltype(topic), Taken<wire::ServiceStatus>&>)
        topic.drain(takers);
    });
  }

  TakenTopics<wire::TopicTypes> taken;
  Course course;
  std::optional<std::int64_t> task_start;  // as task_start_ns() [ns]
  std::size_t judged = 0;                  // states looked at for a reflex
  std::int64_t reflex_since = 0;           // 0: the robot is in none [ns]
  std::size_t counted = 0;                 // rows of the scene that the course has seen
  double wall_first = 0.0, wall_last = 0.0;
  std::uint64_t seq_first = 0, seq_last = 0;
};

struct Recorder::Seat {
  Seat(const wire::BusSettings& settings, const task::Task& task)
      : bus(settings), topics(bus, task) {
    bus.hold_until_promised();
  }
  wire::Bus bus;
  Topics topics;
};

Recorder::Recorder(const wire::BusSettings& bus, const Goal& goal, Recording* recording,
                   const std::filesystem::path& scratch, Listener* listener)
    : settings_(bus), goal_(goal), recording_(recording), listener_(listener), samples_(scratch) {
  if (bus.exchange != nullptr) {
    seat_ = std::make_unique<Seat>(settings_, goal_.task);
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
  Topics topics(bus, goal_.task);
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
  samples_.begin_again();
  topics.course = Course(goal_.task);
  topics.task_start.reset();
  topics.judged = topics.counted = 0;
  topics.reflex_since = 0;
  done_.store(false);
}

void Recorder::look_on(Topics& topics, const wire::Bus& bus) {
  topics.drain({nullptr, nullptr, listener_});
  std::vector<wire::RefusedCount> refused = bus.refusals();
  const std::lock_guard lock(mutex_);
  live_.refused = std::move(refused);
  take_words(topics);
  live_.steps = topics.taken.of<wire::RobotState>().newest.header.seq;
  live_.plan = topics.taken.of<wire::Plan>().newest;
}

void Recorder::finish(Topics& topics) {
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
  topics.taken.of<wire::ServiceStatus>().drain({&samples_, recording_, listener_});
  live_.services = samples_.words();
}

bool Recorder::take_all(Topics& topics, const wire::Bus& bus) {
  const Series& series = samples_.series();
  const std::size_t plans_before = series.plan.size();
  topics.drain({&samples_, recording_, listener_});
  if (topics.taken.of<wire::RobotState>().any) {
    topics.wall_last = wall_time();
    topics.seq_last = series.state.back().seq;
    if (topics.wall_first == 0.0) {
      topics.wall_first = topics.wall_last;
      topics.seq_first = topics.seq_last;
    }
  }
  for (; topics.judged < series.state.size(); ++topics.judged) {
    const StateRow& row = series.state[topics.judged];
    if (!row.reflex) {
      topics.reflex_since = 0;
    } else if (topics.reflex_since == 0) {
      topics.reflex_since = row.time_ns;
    }
  }
  const bool gave_up =
      topics.reflex_since != 0 && !series.state.empty() &&
      seconds(series.state.back().time_ns - topics.reflex_since) > goal_.reflex_patience;
  for (std::size_t i = plans_before; i < series.plan.size() && !topics.task_start; ++i) {
    if (series.plan[i].rolling) topics.task_start = series.plan[i].state_ns;
  }

  // the same count as evaluate(): scenes from the first plan that rolls
  for (; topics.counted < series.scene.size() && topics.task_start; ++topics.counted) {
    const SceneRow& row = series.scene[topics.counted];
    if (row.time_ns >= *topics.task_start)
      topics.course.add(seconds(row.time_ns - *topics.task_start), row);
  }

  std::vector<wire::RefusedCount> refused = bus.refusals();
  const std::lock_guard lock(mutex_);
  live_.refused = std::move(refused);
  take_words(topics);
  if (topics.taken.of<wire::Scene>().any) {
    live_.any = true;
    live_.time = seconds(series.scene.back().time_ns - start_ns(series));
    const SceneRow& row = series.scene.back();
    const double elapsed = topics.task_start ? seconds(row.time_ns - *topics.task_start) : 0.0;
    live_.object_error = worst_error(goal_.task, elapsed, row);
  }
  const auto& plans = topics.taken.of<wire::Plan>();
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
