#pragma once
// A recording on a bus of live processes.
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>

#include "cli/progress.hpp"
#include "cli/recording/listener.hpp"
#include "idl/dds.hpp"

namespace c3rt::cli::replay {

/// Writes samples when it is time, with the present's times: the first one's is now.
class Publisher final : public TimedListener {
 public:
  /// @param rate 2: twice as fast; 0: as fast as it goes
  Publisher(wire::Bus& bus, const std::set<std::string>& topics, double rate, std::int64_t begin_ns,
            std::int64_t end_ns);

  /// Time begins here; before, readers find the writers.
  void begin();
  /// Looked at once a second: why this must end; empty while it may go on.
  void set_watch(std::function<std::string()> watch) { watch_ = std::move(watch); }

  /// Sleeps until it is time.
  void at(std::int64_t time_ns) override;
#define C3RT_TOPIC(Type, ...) void hear(const wire::Type& sample) override;
  C3RT_TOPICS(C3RT_TOPIC)
#undef C3RT_TOPIC
  bool has_enough() const override;

  /// Nothing comes any more.
  void end() { progress_.reset(); }

  const std::string& failure() const { return failure_; }
  const std::map<std::string, std::uint64_t>& written() const { return written_; }  // by topic
  std::uint64_t not_sent() const { return not_sent_; }
  double passed() const;                     // of the recording [s]
  double latest() const { return latest_; }  // that a sample was written behind its time [s]

 private:
  template <typename Types>
  struct WritersOf;
  template <typename... T>
  struct WritersOf<std::tuple<T...>> {
    using Type = std::tuple<std::unique_ptr<wire::Writer<T>>...>;
  };
  /// Of a topic: the number that its newest sample had, and has now.
  struct Numbers {
    std::uint64_t recorded = 0, written = 0;
  };
  template <typename T>
  void publish(const T& recorded);

  const double rate_;
  const std::int64_t begin_ns_, end_ns_;
  std::int64_t began_ns_ = 0;  // of the present
  std::int64_t time_ns_ = 0;   // of the recording
  std::int64_t due_ns_ = 0;    // the same, of the present
  std::int64_t looked_ns_ = 0;
  WritersOf<wire::TopicTypes>::Type writers_;
  Numbers plans_, commands_;
  std::function<std::string()> watch_;
  std::string failure_;
  std::map<std::string, std::uint64_t> written_;
  std::uint64_t not_sent_ = 0;
  double latest_ = 0.0;
  std::optional<Progress> progress_{std::in_place, "replay"};
};

}  // namespace c3rt::cli::replay
