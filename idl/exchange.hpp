#pragma once
// Carries samples between the buses of one process, where DDS would be too slow: simulated time
// goes as fast as the processor does.
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

#include "idl/topics.hpp"

namespace c3rt::wire {

/// Whose a sample is.
struct Sender {
  std::uint64_t writer, bus;
};

/// Samples of one topic on their way to one reader.
class Inbox {
 public:
  /// Of a reader that takes nothing the oldest are lost, as they would be on a network.
  static constexpr std::size_t kMostWaiting = 1 << 14;

  /// @param bus whose reader's it is
  explicit Inbox(const Topic& topic, std::uint64_t bus = 0)
      : topic_(topic), size_(topic.descriptor->m_size), bus_(bus) {}

 private:
  friend class Exchange;
  const Topic& topic_;
  const std::size_t size_;  // of a sample [bytes]
  const std::uint64_t bus_;
  std::uint64_t sent_ = 0;  // newest sequence number that was sent here, whether it arrived or not
  std::vector<char> samples_;
  std::vector<Sender> senders_;  // one for each sample
  std::size_t taken_ = 0;
};

/// What becomes of a sample on its way to one bus.
struct Passage {
  int copies = 1;             // 0: it is lost, and what was promised of it counts as sent
  std::int64_t delay_ns = 0;  // it arrives so much later, in the time of Exchange::arrive()
};

/// What is put is there at once, for every reader that exists and has no bad line. From any thread.
class Exchange {
 public:
  /// @return the newest sequence number of its topic so far, which it will not get
  std::uint64_t add_reader(Inbox& inbox);
  void remove_reader(const Inbox& inbox);
  /// A number that nobody else has.
  std::uint64_t identity();
  void add_writer(const Topic& topic, std::uint64_t writer);
  void remove_writer(const Topic& topic, std::uint64_t writer);
  bool has_writer(const Topic& topic, std::uint64_t writer);
  int readers(const Topic& topic);
  int writers(const Topic& topic);

  /// Looks at every sample of a topic before it is sent, as a bad line would: it may change the
  /// sample, and one that it holds back (false) was never written. An empty one ends it.
  template <typename T>
  void set_filter(const std::function<bool(T&)>& filter) {
    set_filter_of(
        topic<T>(),
        !filter ? Filter() : [filter](void* sample) { return filter(*static_cast<T*>(sample)); });
  }
  bool passes(const Topic& topic, void* sample);

  /// A bad line between a topic and the readers of one bus (Bus::identity()): what was written is
  /// changed, lost, repeated or late for them alone. An empty one ends it.
  template <typename T>
  void set_line(std::uint64_t bus, const std::function<Passage(T&)>& line) {
    set_line_of(
        topic<T>(), bus,
        !line ? Line() : [line](void* sample) { return line(*static_cast<T*>(sample)); });
  }
  /// Time has come so far: what bad lines hold up to then arrives.
  void arrive(std::int64_t now_ns);

  void put(const Topic& topic, const void* sample, const Sender& sender, std::uint64_t seq);
  /// The oldest that was not taken. @return false, and `sample` untouched, if there is none
  bool take(Inbox& inbox, void* sample, Sender& sender);
  /// The newest sequence number that was sent to it.
  std::uint64_t sent(const Inbox& inbox);

 private:
  using Line = std::function<Passage(void*)>;
  using Edge = std::pair<const dds_topic_descriptor_t*, std::uint64_t>;  // to a bus
  struct Held {
    Inbox* inbox;
    std::vector<char> sample;
    Sender sender;
  };
  void set_line_of(const Topic& topic, std::uint64_t bus, Line line);
  void send(Inbox& inbox, const char* bytes, const Sender& sender);
  static void deliver(Inbox& inbox, const char* bytes, const Sender& sender);
  using Filter = std::function<bool(void*)>;
  void set_filter_of(const Topic& topic, Filter filter);
  struct OfTopic {
    std::vector<Inbox*> readers;
    std::vector<std::uint64_t> writers;
    Filter filter;
    std::uint64_t newest_seq = 0;
  };
  OfTopic& of(const Topic& topic) { return topics_[topic.descriptor]; }

  std::mutex mutex_;
  std::uint64_t identities_ = 0;
  std::map<const dds_topic_descriptor_t*, OfTopic> topics_;
  std::map<Edge, Line> lines_;
  std::multimap<std::int64_t, Held>
      held_;  // by when it arrives; of equal times the first put first
  std::int64_t now_ns_ = 0;
};

}  // namespace c3rt::wire
