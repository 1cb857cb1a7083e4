#pragma once
// Takes everything off the bus: time series for the report, the hash, a recording, the newest words
// of each process.
#include <array>
#include <atomic>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "cli/recording/recording.hpp"
#include "cli/recording/samples.hpp"
#include "cli/recording/taken_topics.hpp"
#include "cli/report/metrics.hpp"
#include "idl/dds.hpp"

namespace c3rt::cli {

/// Nobody recovered the robot for this long: the rest of the run would show an arm at rest. [s]
constexpr double kReflexPatience = 3.0;

/// When the recording has seen enough.
struct Goal {
  task::Task task;
  int loops;
  double duration;                           // from the first sample of the scene [s]
  double reflex_patience = kReflexPatience;  // [s]
};

/// What a person wants to see while it runs.
struct Live {
  bool any = false;      // a scene has been seen
  double time = 0.0;     // since the first sample of the scene [s]
  bool rolling = false;  // the task has begun
  double turns = 0.0;
  int loops = 0;
  double object_error = kNone;  // newest distance to the path, of the worst object [m]
  std::optional<wire::Plan> plan;
  Services services;
  std::uint64_t steps = 0;                  // 1 kHz cycles of the plant so far
  std::vector<wire::RefusedCount> refused;  // by the recorder itself
  bool robot_stopped = false;  // in a reflex for longer than kReflexPatience: the run has ended
};

/// Time of the wall since some zero [s].
double wall_time();

class Recorder {
 public:
  static constexpr std::int64_t kPeriod_ns = 20'000'000;  // in simulated time
  /// In lockstep the recorder is a process of its own in the plant's time and misses nothing; in
  /// realtime it reads along. Starts a thread, but not on a bus within this process: there whoever
  /// advances time calls take().
  /// @param recording of what is taken until the goal is reached, and of the last words; outlives
  /// the recorder
  /// @param scratch folder that takes what of the series is too long for the memory; empty: none
  /// @param listener outlives the recorder. In realtime it goes on hearing when the goal is
  /// reached.
  Recorder(const wire::BusSettings& bus, const Goal& goal, Recording* recording = nullptr,
           const std::filesystem::path& scratch = {}, Listener* listener = nullptr);
  ~Recorder();  // stop()
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// On a bus within this process, once per period.
  /// @param newest what has been written
  void take(const wire::Sequences& newest);

  /// The goal was reached: the task is done or the time is over. Recording has ended, in
  /// lockstep at a simulated time that does not depend on the machine.
  bool done() const { return done_.load(); }
  /// In realtime with a listener, once done(): a new recording of the same streams.
  void begin_again(const Goal& goal);
  /// Why recording ended early; empty while it goes on.
  std::string failure() const;
  Live live() const;

  void stop();
  // after stop(), or once done():
  const Samples& samples() const { return samples_; }
  const Series& series() const { return samples_.series(); }
  double real_time_factor() const { return real_time_factor_; }

 private:
  struct Topics;
  struct Seat;
  void run() noexcept;
  void record();
  void finish(Topics& topics);
  void take_words(Topics& topics);                      // of each process; mutex_ is held
  void look_on(Topics& topics, const wire::Bus& bus);   // once done()
  void forget(Topics& topics);                          // what was recorded
  bool take_all(Topics& topics, const wire::Bus& bus);  // true when the goal is reached

  const wire::BusSettings settings_;
  Goal goal_;
  Recording* const recording_;
  Listener* const listener_;
  Samples samples_;
  double real_time_factor_ = kNone;

  mutable std::mutex mutex_;  // of what follows
  Live live_;
  std::string failure_;
  std::optional<Goal> next_goal_;  // under the mutex
  std::atomic<bool> done_{false}, stop_{false};
  std::thread thread_;
  std::unique_ptr<Seat> seat_;  // on a bus within this process
};

}  // namespace c3rt::cli
