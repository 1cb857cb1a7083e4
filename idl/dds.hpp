#pragma once
// The one layer over Cyclone DDS: participant, writer, reader. Only files of idl/ include
// <dds/...>. Within one process the same bus goes without DDS (BusSettings::exchange).
#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "idl/topics.hpp"
#include "idl/validate.hpp"

namespace c3rt::wire {

/// Cannot open the bus, a topic, a reader or a writer; the text names it and says why.
class WireError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The DDS profile is wrong, has no room for another participant, or wants keys that are missing or
/// refused: a mistake in the configuration.
class ProfileError : public WireError {
 public:
  using WireError::WireError;
};

enum class ClockMode { kRealtime, kLockstep };

class Exchange;
/// For buses of this process alone: samples go from writer to reader under the same rules, without
/// DDS. A reader gets what is written while it exists.
std::shared_ptr<Exchange> make_exchange();

struct BusSettings {
  std::uint32_t domain = 0;
  std::string profile_uri;  // a file as those of config/dds/, or its text; empty: the environment's
                            // CYCLONEDDS_URI
  /// Whose keys this bus shows where the profile is secure (security.hpp): "planner"; of every
  /// command and program that is no process, "client".
  std::string identity = "client";
  ClockMode clock = ClockMode::kRealtime;
  std::uint64_t session_id = 0;  // 0: adopt the plant's
  /// This process has the clock that the samples' times are of. A client on another host has not,
  /// and then no sample is refused for lying ahead.
  bool shares_clock = true;
  /// Not DDS, but the buses of this process with the same exchange; lockstep alone, and domain and
  /// profile mean nothing.
  std::shared_ptr<Exchange> exchange = nullptr;
};

/// Gives the calling thread SCHED_FIFO at the priority of threads that carry samples, below every
/// servo thread's. Where that is not allowed nothing changes.
void raise_to_bus_priority() noexcept;

/// Move-only owner of one DDS handle.
class Entity {
 public:
  Entity() = default;
  explicit Entity(std::int32_t handle) : handle_(handle) {}
  Entity(Entity&& other) noexcept : handle_(other.handle_) { other.handle_ = 0; }
  Entity& operator=(Entity&& other) noexcept;
  ~Entity();
  std::int32_t handle() const { return handle_; }

 private:
  std::int32_t handle_ = 0;
};

/// What this process saw go wrong between it and its peers: one sentence per topic and peer, never
/// silent.
struct PeerProblem {
  std::string topic;
  std::string text;  // "robot/state: reader of another process requests RELIABLE, this writer
                     // offers BEST_EFFORT"
};

/// Samples that the readers of a process refused, of one topic and for one reason.
struct RefusedCount {
  std::string topic;
  Reason reason;
  std::uint64_t count;
  std::string latest;  // of the newest that was looked at: what came and what was expected
  std::string from;    // its writer: "python3 (pid 12)"
};

class ReaderBase;
class WriterBase;

/// One DDS participant and the session that its samples belong to. Outlives its readers and
/// writers.
class Bus {
 public:
  /// @throws ProfileError if the profile is missing or refused, WireError if the domain cannot be
  /// joined
  explicit Bus(const BusSettings& settings);
  ~Bus();
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;

  std::int32_t participant() const;
  ClockMode clock() const;
  std::uint64_t identity() const noexcept;        // within one process, on its exchange
  std::uint64_t session_id() const noexcept;      // 0 until the plant was heard
  void adopt_session(std::uint64_t id) noexcept;  // as if the plant had told it
  /// What the readers of this bus have refused since their start, by topic and reason. From any
  /// thread.
  std::vector<RefusedCount> refusals() const;
  /// Peers that discovery shows on our topics and that can never be served: incompatible QoS or
  /// types.
  std::vector<PeerProblem> problems() const;

  // What follows pumps the readers of this bus (those made with Wakes::kBus): call it from the
  // thread that takes from them. wake() may be called from any thread.

  /// Blocks until a new sample is there for any reader of this bus, `wake()` was called, or the
  /// time is over.
  void wait_for_data(std::int64_t timeout_ns);
  void wake() noexcept;

  /// Lockstep: blocks until each reader of a stream in `newest_seq` holds that sequence number, and
  /// lets the readers give out samples up to that number and no further: what a process sees at a
  /// tick does not depend on who was faster within the tick.
  /// @return false and the topic's name in `missing` after timeout_ns.
  bool wait_for(const Sequences& newest_seq, std::int64_t timeout_ns, std::string& missing);
  /// Lockstep: from now on a reader of a stream gives out nothing that no wait_for() has promised.
  void hold_until_promised() noexcept;
  /// Newest sequence numbers that the writers of this bus have written, by stream (for Done and
  /// Tick).
  void newest_written(Sequences& newest_seq) const noexcept;

 private:
  friend class ReaderBase;
  friend class WriterBase;
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

class WriterBase {
 public:
  std::uint64_t seq() const noexcept { return seq_.load(); }
  int matched_readers() const;  // 0: nobody listens

 protected:
  WriterBase(Bus& bus, const Topic& topic, std::optional<Process> addressee);
  ~WriterBase();
  bool write_sample(Header& header, void* sample, std::int64_t time_ns) noexcept;

 private:
  Bus& bus_;
  const Topic& topic_;
  Exchange* exchange_;  // nullptr: DDS
  std::uint64_t identity_ = 0;
  Entity topic_entity_, writer_;
  std::atomic<std::uint64_t> seq_{0};
};

/// Writes samples; fills in session, sequence and time. One thread per writer, and not the servo
/// thread: Cyclone allocates in a write.
template <typename T>
class Writer : public WriterBase {
 public:
  /// @param addressee of an addressed topic; nothing: all
  explicit Writer(Bus& bus, std::optional<Process> addressee = {})
      : WriterBase(bus, topic<T>(), addressee) {}
  /// @param time_ns when the sample takes effect (in lockstep: simulated, with the scenario's
  /// delays)
  /// @return false if the sample was not sent (readers too slow for longer than the QoS allows);
  /// its number is reused
  bool write(T& sample, std::int64_t time_ns) noexcept {
    return write_sample(sample.header, &sample, time_ns);
  }
};

struct ReaderCounters {
  std::uint64_t received = 0;
  std::uint64_t lost = 0;  // gaps in the sequence
  std::array<std::uint64_t, kReasonCount> refused{};
  std::uint64_t refused_for(Reason reason) const noexcept {
    return refused[static_cast<std::size_t>(reason)];
  }
};

template <typename T>
constexpr bool kAnswered = topic<T>().trait == Trait::kAnswered;

/// Whom a reader's new sample wakes.
enum class Wakes {
  kBus,     // Bus::wait_for_data(); the reader belongs to the thread that calls it
  kItself,  // ReaderBase::wait(); for a thread of its own
};

class ReaderBase {
 public:
  ReaderBase(const ReaderBase&) = delete;
  ReaderBase& operator=(const ReaderBase&) = delete;

  ReaderCounters counters() const noexcept;  // from any thread
  std::uint64_t newest_seq() const noexcept { return newest_seq_; }
  std::uint64_t taken_from() const noexcept;  // writer of the sample that was taken last; 0: none
  std::string name_of_writer(std::uint64_t writer) const;  // "c3rt-plant (pid 12)"
  int matched_writers() const;                             // known, also when they have just died
  int alive_writers() const;  // matched and not silent for longer than their liveliness lease
  std::uint64_t missed_deadlines()
      const;  // realtime topics with a deadline: periods without a sample
  /// Wakes::kItself only: blocks until there is a new sample, interrupt() was called, or the time
  /// is over.
  void wait(std::int64_t timeout_ns);
  void interrupt() noexcept;

 protected:
  /// @param depth samples kept until taken: the history of the DDS reader and of the queue here
  ReaderBase(Bus& bus, const Topic& topic, int depth, Wakes wakes,
             std::optional<Process> addressee);
  virtual ~ReaderBase();

  virtual void* sample_at(int slot) noexcept = 0;
  virtual Header& header_at(int slot) noexcept = 0;
  virtual Refusal check(int slot) const noexcept = 0;                    // validate() of its type
  virtual void keep_refused(int slot, const Refusal& why) noexcept = 0;  // of a request

  /// Moves samples from DDS to the queue, in the order of their sequence numbers, and applies the
  /// rules: values, one writer, the plant's session (0 is a client's, where clients may write), a
  /// growing sequence of each writer. What they refuse is counted by reason, with its writer's
  /// name.
  /// @return number of samples accepted. No heap beyond Cyclone's while nothing new is refused.
  int pump() noexcept;
  /// The slot of the oldest queued sample that may be given out; -1 if there is none.
  int front() noexcept;
  void pop() noexcept;
  static int queue_depth(const Bus& bus, const Topic& topic, int depth);

  Bus& bus_;
  const Topic& topic_;

 private:
  friend class Bus;
  struct Implementation;
  struct Source;
  void join_dds(int depth, Wakes wakes, std::optional<Process> addressee);
  /// Whether the sample is let in as far as its writer and its session go.
  Reason judge(const Header& header, const Source& source, std::int64_t now_ns) noexcept;
  void refuse(const Refusal& refusal, const Header& header, const Source& source) noexcept;
  RefusedCount refusal(Reason reason) const;  // what is known of it
  void allow(std::uint64_t seq) noexcept;     // lockstep: give out samples up to here
  /// Lockstep: it has come, or will not come any more as a bad line has it.
  bool has_come(std::uint64_t seq) const;

  std::uint64_t newest_seq_ = 0;
  std::unique_ptr<Implementation> implementation_;
};

/// Reads samples in order. Not for the servo thread; see Inlet in process.hpp.
template <typename T>
class Reader : public ReaderBase {
 public:
  /// @param addressee of an addressed topic; nothing: all
  explicit Reader(Bus& bus, int depth = 64, Wakes wakes = Wakes::kBus,
                  std::optional<Process> addressee = {})
      : ReaderBase(bus, topic<T>(), depth, wakes, addressee),
        slots_(queue_depth(bus, topic<T>(), depth) + 1) {}
  ~Reader() override = default;

  /// Next sample in order; false, and `out` untouched, if there is none.
  bool take(T& out) noexcept {
    pump();
    const int slot = front();
    if (slot < 0) return false;
    out = slots_[slot];
    pop();
    return true;
  }
  /// Requests: the next one that was refused, to be answered with the reason. At most 8 are kept.
  bool take_refused(T& out, Refusal& why) noexcept {
    static_assert(kAnswered<T>);
    pump();
    if (oldest_refused_ == newest_refused_) return false;
    const Refused& refused = refused_[oldest_refused_++ % kRefused];
    out = refused.sample;
    why = refused.why;
    return true;
  }
  /// Newest sample; older ones are dropped.
  bool take_newest(T& out) noexcept {
    bool found = false;
    while (take(out)) found = true;
    return found;
  }
  /// Next sample in order whose time has come, for topics with several keys; see take_effective.
  bool take_next_effective(std::int64_t now_ns, T& out) noexcept {
    pump();
    const int slot = front();
    if (slot < 0 || slots_[slot].header.time_ns > now_ns) return false;
    out = slots_[slot];
    pop();
    return true;
  }
  /// Newest sample whose time has come: header.time_ns <= now_ns. Older ones are dropped, later
  /// ones stay.
  bool take_effective(std::int64_t now_ns, T& out) noexcept {
    pump();
    bool found = false;
    for (int slot = front(); slot >= 0 && slots_[slot].header.time_ns <= now_ns; slot = front()) {
      out = slots_[slot];
      pop();
      found = true;
    }
    return found;
  }

 private:
  void* sample_at(int slot) noexcept override { return &slots_[slot]; }
  Header& header_at(int slot) noexcept override { return slots_[slot].header; }
  Refusal check(int slot) const noexcept override { return validate(slots_[slot]); }
  void keep_refused(int slot, const Refusal& why) noexcept override {
    if constexpr (kAnswered<T>) {
      refused_[newest_refused_++ % kRefused] = {slots_[slot], why};
      oldest_refused_ = std::max(oldest_refused_ + kRefused, newest_refused_) - kRefused;
    }
  }

  static constexpr std::size_t kRefused = 8;
  struct Refused {
    T sample;
    Refusal why;
  };
  std::vector<T> slots_;
  std::array<Refused, kAnswered<T> ? kRefused : 0> refused_{};
  std::size_t newest_refused_ = 0, oldest_refused_ = 0;
};

}  // namespace c3rt::wire
