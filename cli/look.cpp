#include "cli/look.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <set>
#include <string_view>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/exit_status.hpp"
#include "cli/fields.hpp"
#include "cli/paths.hpp"
#include "cli/table.hpp"
#include "config/text.hpp"
#include "idl/client/client.hpp"
#include "idl/discovery.hpp"
#include "idl/process.hpp"

namespace c3rt::cli {
namespace {

using std::chrono::steady_clock;

/// A sample as a JSON object.
class JsonVisitor {
 public:
  template <typename T>
  void operator()(const char* name, const T& value) {
    // what every sample has stands beside the rest
    if constexpr (std::is_same_v<T, wire::Header> || std::is_same_v<T, wire::Origin>) {
      wire::visit_fields(value, *this);
    } else {
      object_[name] = json_of(value);
    }
  }
  void machine_time(const char* name, double value) { object_[name] = value; }
  /// The first `count` elements.
  template <typename T, std::size_t n>
  void list(const char* name, const T (&values)[n], int count) {
    nlohmann::ordered_json all = nlohmann::ordered_json::array();
    for (int i = 0; i < count && i < static_cast<int>(n); ++i) all.push_back(json_of(values[i]));
    object_[name] = all;
  }
  std::string text() const { return object_.dump(); }

 private:
  template <typename T>
  static nlohmann::ordered_json json_of(const T& value) {
    if constexpr (std::is_array_v<T>) {
      if constexpr (std::is_same_v<std::remove_extent_t<T>, char>) {
        return config::printable(value, sizeof value * 4);
      } else {
        nlohmann::ordered_json list = nlohmann::ordered_json::array();
        for (const auto& element : value) list.push_back(json_of(element));
        return list;
      }
    } else if constexpr (std::is_enum_v<T>) {
      return name_of(value);
    } else if constexpr (std::is_class_v<T>) {
      JsonVisitor inside;
      wire::visit_fields(value, inside);
      return inside.object_;
    } else {
      return value;
    }
  }
  nlohmann::ordered_json object_;
};

/// Tells on stderr what is refused, once for each kind.
class RefusalTeller {
 public:
  void look(const wire::Bus& bus) {
    for (const wire::RefusedCount& refused : bus.refusals()) {
      const std::string kind =
          fmt::format("{} ({}) from {}", refused.topic, reason_name(refused.reason), refused.from);
      if (told_.insert(kind).second)
        fmt::print(stderr, "c3rt: refused {}: {}\n", kind, refused.latest);
    }
  }

 private:
  std::set<std::string> told_;
};

/// Gives every sample of T to `action` until it returns false or a stop is requested, and nothing
/// now and then. @return kCriterionFailed after a silence of `timeout_s`
template <typename T, typename Action>
int follow(const Seat& seat, double timeout_s, Action&& action) {
  wire::Bus bus(bus_settings(seat));
  wire::Reader<T> reader(bus, 1024);
  T sample{};
  RefusalTeller refusals;
  const auto patience = std::chrono::duration<double>(timeout_s);
  auto heard = steady_clock::now();
  bool go_on = true;
  while (go_on && !wire::StopFlag::requested()) {
    bus.wait_for_data(100'000'000);
    bool any = false;
    while (go_on && reader.take(sample)) {
      any = true;
      go_on = action(&sample, reader);
    }
    if (!any) go_on = action(nullptr, reader);
    refusals.look(bus);
    // an event may be long in coming; who could write it is enough
    const bool may_come = wire::topic<T>().qos == wire::Qos::kEvent && reader.matched_writers() > 0;
    if (any || may_come) heard = steady_clock::now();
    if (go_on && timeout_s > 0.0 && steady_clock::now() - heard > patience) {
      const int writers = reader.matched_writers();
      fmt::print(stderr, "c3rt: error: {} {} on domain {} for {:g} s (--timeout 0 waits on)\n",
                 writers == 0 ? "nobody has written"
                              : fmt::format("{} writers, but no sample of", writers),
                 wire::topic<T>().name, seat.domain, timeout_s);
      return kCriterionFailed;
    }
  }
  return kDone;
}

/// What tells the instances of a topic apart, in words: "camera 0 object 1", "vision". The robot
/// and the number of a request do not: there is one, and another one each time.
class KeyVisitor {
 public:
  template <typename T>
  void operator()(const char* name, const T& value) {
    if constexpr (std::is_enum_v<T>) {
      add(name_of(value));
    } else if constexpr (sizeof value < sizeof(std::uint64_t)) {
      if (std::string_view(name) != "robot") add(fmt::format("{} {}", name, value));
    }
  }
  const std::string& text() const { return text_; }

 private:
  void add(const std::string& word) { text_ += (text_.empty() ? "" : " ") + word; }
  std::string text_;
};

template <typename T>
std::string key_of(const T& sample) {
  KeyVisitor key;
  wire::visit_key(sample, key);
  return key.text();
}

/// The samples of one key from one writer.
struct Flow {
  std::int64_t last_ns = 0;
  std::vector<double> gaps;  // between the times that the samples carry, of this second [s]
};

std::string report_line(const std::vector<double>& gaps) {
  if (gaps.empty()) return "no samples";
  double sum = 0.0;
  for (const double gap : gaps) sum += gap;
  const double mean = sum / static_cast<double>(gaps.size());
  double squares = 0.0;
  for (const double gap : gaps) squares += (gap - mean) * (gap - mean);
  return fmt::format("{:8.2f} Hz  n {}  gap min {:.3f}  max {:.3f}  sd {:.3f} ms",
                     mean > 0.0 ? 1.0 / mean : 0.0, gaps.size(),
                     *std::min_element(gaps.begin(), gaps.end()) * 1e3,
                     *std::max_element(gaps.begin(), gaps.end()) * 1e3,
                     std::sqrt(squares / static_cast<double>(gaps.size())) * 1e3);
}

}  // namespace

void unknown_topic(const std::string& name) {
  std::string known;
  wire::for_each_topic([&](const auto& sample) {
    known += (known.empty() ? "" : ", ") +
             std::string(wire::topic<std::decay_t<decltype(sample)>>().name);
  });
  throw UsageError("unknown topic \"" + name + "\"; known: " + known);
}

int print_topics(const Seat& seat, bool peers) {
  wire::Bus bus(bus_settings(seat));
  struct Row {
    const wire::Topic* topic;
    std::unique_ptr<wire::ReaderBase, void (*)(wire::ReaderBase*)> reader;
    std::uint64_t received = 0;  // before the second that is counted
  };
  std::vector<Row> rows;
  wire::for_each_topic([&](const auto& sample) {
    using T = std::decay_t<decltype(sample)>;
    rows.push_back(
        {&wire::topic<T>(), {new wire::Reader<T>(bus, 256), [](wire::ReaderBase* reader) {
                               delete static_cast<wire::Reader<T>*>(reader);
                             }}});
  });
  const auto pump_for = [&bus](std::chrono::milliseconds time) {
    const auto end = steady_clock::now() + time;
    while (steady_clock::now() < end && !wire::StopFlag::requested()) {
      bus.wait_for_data(1'000'000);
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  };
  pump_for(std::chrono::milliseconds(1000));  // discovery, and what is kept for late readers
  for (Row& row : rows) row.received = row.reader->counters().received;
  const auto begin = steady_clock::now();
  pump_for(std::chrono::milliseconds(1000));
  const double seconds = std::chrono::duration<double>(steady_clock::now() - begin).count();

  const std::vector<wire::PeerEndpoint> endpoints = wire::peer_endpoints(bus);
  fmt::print("  {:<16} {:>7} {:>7} {:>8}  {:<24} {}\n", "topic", "writers", "readers", "rate Hz",
             "type", "offered");
  for (const Row& row : rows) {
    const auto count = [&](bool writers) {
      return std::count_if(endpoints.begin(), endpoints.end(), [&](const auto& endpoint) {
        return endpoint.topic == row.topic->name && endpoint.is_writer == writers;
      });
    };
    const double rate =
        static_cast<double>(row.reader->counters().received - row.received) / seconds;
    fmt::print("  {:<16} {:>7} {:>7} {:>8.1f}  {:<24} {}\n", row.topic->name, count(true),
               count(false), rate, row.topic->descriptor->m_typename,
               wire::offered_qos(*row.topic));
    for (const wire::PeerEndpoint& endpoint : endpoints) {
      if (!peers || endpoint.topic != row.topic->name) continue;
      fmt::print("    {} {} (pid {} on {}): {}\n", endpoint.is_writer ? "writer" : "reader",
                 config::printable(endpoint.process), endpoint.pid,
                 config::printable(endpoint.host), endpoint.qos);
    }
  }
  fmt::print("{}", service_table(client::listen(bus, 0.5)));
  for (const wire::PeerProblem& problem : bus.problems())
    fmt::print("  problem: {}\n", config::printable(problem.text, 500));
  return kDone;
}

int echo(const Seat& seat, const LookSettings& settings) {
  int printed = 0, status = kDone;
  const bool known = wire::with_topic(settings.topic, [&](const auto& kind) {
    using T = std::decay_t<decltype(kind)>;
    status = follow<T>(seat, settings.timeout_s, [&](const T* sample, const wire::ReaderBase&) {
      if (sample == nullptr) return true;
      JsonVisitor visitor;
      visit_sample(*sample, visitor);
      fmt::print("{}\n", visitor.text());
      std::fflush(stdout);
      return settings.count == 0 || ++printed < settings.count;
    });
  });
  if (!known) unknown_topic(settings.topic);
  return status;
}

int measure_rate(const Seat& seat, const LookSettings& settings) {
  int status = kDone;
  const bool known = wire::with_topic(settings.topic, [&](const auto& kind) {
    using T = std::decay_t<decltype(kind)>;
    std::map<std::pair<std::string, std::uint64_t>, Flow> flows;  // by key and writer
    std::map<std::uint64_t, std::string> writers;
    int reports = 0;
    auto next = steady_clock::now() + std::chrono::seconds(1);
    status =
        follow<T>(seat, settings.timeout_s, [&](const T* sample, const wire::ReaderBase& reader) {
          if (sample != nullptr) {
            const std::uint64_t writer = reader.taken_from();
            if (writers.count(writer) == 0) writers[writer] = reader.name_of_writer(writer);
            Flow& flow = flows[{key_of(*sample), writer}];
            if (flow.last_ns != 0)
              flow.gaps.push_back(static_cast<double>(sample->header.time_ns - flow.last_ns) *
                                  1e-9);
            flow.last_ns = sample->header.time_ns;
          }
          if (steady_clock::now() < next) return true;
          next = steady_clock::now() + std::chrono::seconds(1);
          if (flows.empty()) fmt::print("no samples\n");
          for (auto& [source, flow] : flows) {
            const auto& [key, writer] = source;
            fmt::print("{}  {}{}{}\n", report_line(flow.gaps), key, key.empty() ? "" : ", ",
                       config::printable(writers[writer]));
            flow.gaps.clear();
          }
          if (const std::uint64_t lost = reader.counters().lost; lost > 0)
            fmt::print("lost {} since the start\n", lost);
          std::fflush(stdout);
          return settings.count == 0 || ++reports < settings.count;
        });
  });
  if (!known) unknown_topic(settings.topic);
  return status;
}

}  // namespace c3rt::cli
