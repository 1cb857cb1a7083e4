#pragma once
// The one layer over Cyclone DDS: participant, writer, reader. Only files of idl/ include <dds/...>.
#include <array>
#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "idl/topics.hpp"

namespace c3rt::wire {

/// Cannot open the bus, a topic, a reader or a writer; the text names it and says why.
class WireError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

enum class ClockMode { kRealtime, kLockstep };

struct BusSettings {
  std::uint32_t domain = 0;
  std::string profile_uri;  // a file of config/dds/, given to Cyclone; empty: the environment's CYCLONEDDS_URI
  ClockMode clock = ClockMode::kRealtime;
  std::uint64_t session_id = 0;  // 0: adopt the newest that the plant writes
};

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

/// What this process saw go wrong between it and its peers: one sentence per topic and peer, never silent.
struct PeerProblem {
  std::string topic;
  std::string text;  // "robot/state: reader of another process requests RELIABLE, this writer offers BEST_EFFORT"
};

class ReaderBase;

/// One DDS participant and the session that its samples belong to.
class Bus {
 public:
  explicit Bus(const BusSettings& settings);
  ~Bus();
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;

  std::int32_t participant() const;
  ClockMode clock() const;
  std::uint64_t session_id() const noexcept;        // 0 until the plant was heard
  void adopt_session(std::uint64_t id) noexcept;    // keeps the larger of both
  std::vector<PeerProblem> problems() const;        // incompatible QoS or types, by topic and peer

  /// Blocks until any reader of this bus has data, `wake()` was called, or the time is over.
  void wait_for_data(std::int64_t timeout_ns);
  void wake() noexcept;

  /// Lockstep: blocks until each reader of a stream in `newest_seq` holds that sequence number.
  /// @return false and the topic's name in `missing` after timeout_ns.
  bool wait_for(const unsigned long long (&newest_seq)[c3rt_v1_TOPIC_COUNT], std::int64_t timeout_ns,
                std::string& missing);
  /// Newest sequence numbers that the writers of this bus have written, by stream (for Done and Tick).
  void newest_written(unsigned long long (&newest_seq)[c3rt_v1_TOPIC_COUNT]) const noexcept;

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
  WriterBase(Bus& bus, const Topic& topic);
  ~WriterBase();
  bool write_sample(Header& header, const void* sample, std::int64_t time_ns) noexcept;

 private:
  Bus& bus_;
  const Topic& topic_;
  Entity topic_entity_, writer_;
  std::atomic<std::uint64_t> seq_{0};
};

/// Writes samples; fills in session, sequence and time. Not for the servo thread: Cyclone allocates in a write.
template <typename T>
class Writer : public WriterBase {
 public:
  explicit Writer(Bus& bus) : WriterBase(bus, topic<T>()) {}
  /// @param time_ns when the sample takes effect (in lockstep: simulated, with the scenario's delays)
  bool write(T& sample, std::int64_t time_ns) noexcept {
    return write_sample(sample.header, &sample, time_ns);
  }
};

struct ReaderCounters {
  std::uint64_t received = 0;
  std::uint64_t lost = 0;           // gaps in the sequence
  std::uint64_t other_session = 0;  // dropped: from an older or unknown session
  std::uint64_t out_of_order = 0;   // dropped: sequence number not newer
};

class ReaderBase {
 public:
  const ReaderCounters& counters() const noexcept { return counters_; }
  std::uint64_t newest_seq() const noexcept { return newest_seq_; }
  int matched_writers() const;

 protected:
  /// @param depth samples kept until taken (history of the DDS reader)
  ReaderBase(Bus& bus, const Topic& topic, int depth);
  virtual ~ReaderBase();
  /// Takes one sample from DDS into `sample`; false if there is none. Applies the session and sequence rules:
  /// an accepted sample is of the bus's session (session 0 = from a client: always accepted) and newer.
  bool take_sample(Header& (*header_of)(void*), void* sample) noexcept;
  virtual void pump() noexcept = 0;  // DDS -> queue

  Bus& bus_;
  const Topic& topic_;

 private:
  friend class Bus;
  Entity topic_entity_, reader_, condition_;
  ReaderCounters counters_;
  std::uint64_t newest_seq_ = 0;
  std::uint64_t newest_session_ = 0;
};

/// Reads samples in order. Not for the servo thread; see Inlet in process.hpp.
template <typename T>
class Reader : public ReaderBase {
 public:
  explicit Reader(Bus& bus, int depth = 64) : ReaderBase(bus, topic<T>(), depth), depth_(depth) {}
  ~Reader() override = default;

  /// Next sample in order; false, and `out` untouched, if there is none.
  bool take(T& out) noexcept {
    pump();
    if (queue_.empty()) return false;
    out = queue_.front();
    queue_.pop_front();
    return true;
  }
  /// Newest sample whose time has come: header.time_ns <= now_ns. Older ones are dropped, later ones stay.
  bool take_effective(std::int64_t now_ns, T& out) noexcept {
    pump();
    bool found = false;
    while (!queue_.empty() && queue_.front().header.time_ns <= now_ns) {
      out = queue_.front();
      queue_.pop_front();
      found = true;
    }
    return found;
  }

 protected:
  void pump() noexcept override {
    static const auto header_of = [](void* sample) -> Header& { return static_cast<T*>(sample)->header; };
    while (take_sample(header_of, &scratch_)) {
      if (static_cast<int>(queue_.size()) >= depth_) queue_.pop_front();
      queue_.push_back(scratch_);
    }
  }

 private:
  int depth_;
  T scratch_{};
  std::deque<T> queue_;
};

}  // namespace c3rt::wire
