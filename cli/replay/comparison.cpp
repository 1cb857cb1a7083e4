#include "cli/replay/comparison.hpp"

#include <algorithm>
#include <array>
#include <deque>
#include <limits>
#include <map>
#include <optional>
#include <tuple>
#include <type_traits>
#include <utility>

#include <fmt/format.h>

#include "cli/progress.hpp"
#include "cli/replay/alone.hpp"
#include "cli/replay/differences.hpp"
#include "controller/base/time.hpp"
#include "idl/process.hpp"
#include "plant_emulator/node.hpp"

namespace c3rt::cli::replay {
namespace {

using base::nanoseconds;
using base::seconds;

/// An answer that waits so long for the other one is alone [ns].
constexpr std::int64_t kPatience_ns = 5'000'000'000;

/// What an answer is made from, its camera and object: the same for both that belong together.
using Key = std::array<std::int64_t, 3>;

/// Answers on one topic that wait for those of the other side.
template <typename T>
struct Answers {
  Answers(wire::Bus& ears, std::size_t the_index) : reader(ears), index(the_index) {}
  wire::Reader<T> reader;
  const std::size_t index;  // of its result
  std::map<Key, T> recorded, given;
  Key last_recorded{};
};

/// planner/debug names its plan, and that tells what both are made from.
struct NewestPlan {
  std::uint64_t seq = 0;
  std::int64_t state_ns = 0;
};

std::optional<Key> key_of(const wire::Plan& s, NewestPlan& newest) {
  newest = {s.header.seq, s.origin.state_ns};
  return Key{s.origin.state_ns};
}
std::optional<Key> key_of(const wire::PlannerDebug& s, NewestPlan& newest) {
  if (s.plan_seq != newest.seq) return {};  // of one that was lost
  return Key{newest.state_ns};
}
std::optional<Key> key_of(const wire::RobotCommand& s, NewestPlan&) {
  return Key{s.origin.state_ns};
}
std::optional<Key> key_of(const wire::ObjectEstimate& s, NewestPlan&) {
  return Key{s.exposure_ns, s.object_index};
}
std::optional<Key> key_of(const wire::ObjectDetection& s, NewestPlan&) {
  return Key{s.exposure_ns, s.camera, s.object_index};
}

using AnswerTypes = std::tuple<wire::Plan, wire::PlannerDebug, wire::ObjectEstimate,
                               wire::ObjectDetection, wire::RobotCommand>;
template <typename T, typename Types>
struct IsOneOf;
template <typename T, typename... Types>
struct IsOneOf<T, std::tuple<Types...>> : std::disjunction<std::is_same<T, Types>...> {};

template <typename Types>
struct AllAnswers;
template <typename... T>
struct AllAnswers<std::tuple<T...>> {
  using Type = std::tuple<std::optional<Answers<T>>...>;
};

/// Added to the times of a topic's samples: when they are seen first by who acts at that time. What
/// the plant writes in a cycle is there in the next one, whose time it has. What others write at
/// once, they write while the rest acts.
InOrder::Shifts shifts_of(const config::Scenario& scenario, wire::Process process, bool realtime) {
  InOrder::Shifts shifts{};
  const std::int64_t delay_ns = nanoseconds(scenario.planner.publish_delay);
  if (realtime) {
    // in the place where it was made, not where it takes effect
    if (process == c3rt_v2_PROCESS_PLANNER)
      shifts[wire::table::kPlaceOfPlan] = shifts[wire::table::kPlaceOfPlannerDebug] = -delay_ns;
    return shifts;
  }
  shifts[wire::table::kPlaceOfRobotCommand] = 1;
  if (delay_ns == 0 && scenario.timing.solve_time_s == 0.0) shifts[wire::table::kPlaceOfPlan] = 1;
  if (scenario.timing.vision_latency_s == 0.0) shifts[wire::table::kPlaceOfObjectEstimate] = 1;
  return shifts;
}

/// A run acts in its first cycle, then in the first one of each period.
std::int64_t cycle_of(std::int64_t due_ns) {
  return (due_ns + plant::kCycleNs - 1) / plant::kCycleNs * plant::kCycleNs;
}
std::int64_t first_step_ns(std::int64_t begin_ns, std::int64_t period_ns) {
  if (begin_ns <= plant::kCycleNs) return plant::kCycleNs;
  return cycle_of((begin_ns + period_ns - 1) / period_ns * period_ns);
}

}  // namespace

std::uint64_t ComparisonResult::recorded() const {
  std::uint64_t sum = 0;
  for (const TopicResult& topic : topics) sum += topic.recorded;
  return sum;
}

bool ComparisonResult::all_same() const {
  return std::all_of(topics.begin(), topics.end(), [](const TopicResult& topic) {
    return topic.same == topic.recorded && topic.same == topic.given;
  });
}

struct Comparison::Implementation {
  Implementation(const config::Scenario& s, wire::Process the_process, std::uint64_t seed,
                 const Overview& of, bool is_realtime)
      : process(the_process),
        overview(of),
        realtime(is_realtime),
        publish_delay_ns(nanoseconds(s.planner.publish_delay)),
        shifts(shifts_of(s, the_process, is_realtime)),
        alone(s, the_process, seed, of.session),
        next_step_ns(first_step_ns(of.begin_ns, alone.period_ns())) {
    make_readers(static_cast<AnswerTypes*>(nullptr));
    for (const Asked& asked_for : of.asked) {
      if (asked_for.process() != process) continue;
      // its answer tells when it was taken, where that does not wait for more
      const auto answer = of.answered_ns.find(asked_for.request_id());
      const bool at_once = process != c3rt_v2_PROCESS_IMPEDANCE;
      const bool known = at_once && answer != of.answered_ns.end();
      asked.emplace(known ? answer->second : asked_for.place_ns, &asked_for);
    }
  }

  template <typename... T>
  void make_readers(std::tuple<T...>*) {
    (make_reader<T>(), ...);
  }
  template <typename T>
  void make_reader() {
    if (wire::topic<T>().writer != process) return;
    std::get<std::optional<Answers<T>>>(answers).emplace(alone.ears(), result.topics.size());
    result.topics.push_back({wire::topic<T>().name, 0, 0, 0});
  }
  template <typename Action>
  void for_each(Action&& action) {
    std::apply([&](auto&... topic) { ((topic ? action(*topic) : void()), ...); }, answers);
  }

  template <typename T>
  void take(const T& sample) {
    // what is asked of it is given by when it was taken; answers and words are nobody's input
    if constexpr (keeps_time(wire::topic<T>())) {
      if (sample.header.session_id != overview.session) return;
      if constexpr (IsOneOf<T, AnswerTypes>::value) {
        if (wire::topic<T>().writer == process) {
          if (realtime) act_as(sample);
          judge_recorded(sample);
          return;
        }
      }
      input(sample);
    }
  }

  template <typename T>
  void input(const T& sample) {
    alone.give(sample);
  }
  // of these an answer in realtime says up to which it is made from them
  void input(const wire::RobotState& sample) {
    realtime ? states.push_back(sample) : alone.give(sample);
  }
  void input(const wire::Scene& sample) {
    realtime ? scenes.push_back(sample) : alone.give(sample);
  }
  void input(const wire::ObjectEstimate& sample) {
    realtime ? estimates.push_back(sample) : alone.give(sample);
  }

  template <typename T, typename Time>
  void give_up_to(std::deque<T>& waiting, std::int64_t last_ns, Time&& time) {
    for (; !waiting.empty() && time(waiting.front()) <= last_ns; waiting.pop_front())
      alone.give(waiting.front());
  }

  template <typename T>
  void act_as(const T&) {}
  void act_as(const wire::Plan& made) {
    const auto by_time = [](const auto& sample) { return sample.header.time_ns; };
    give_up_to(states, made.origin.state_ns, by_time);
    give_up_to(estimates, made.origin.exposure_ns,
               [](const wire::ObjectEstimate& estimate) { return estimate.exposure_ns; });
    // a solve that takes longer than the delay takes effect when it is done
    const std::int64_t took_ns = std::max(publish_delay_ns, nanoseconds(made.solve_time_s));
    step(made.header.time_ns - took_ns);
  }
  void act_as(const wire::ObjectEstimate& made) {
    if (made.exposure_ns <= exposure_ns) return;  // another object at the same exposure
    exposure_ns = made.exposure_ns;
    const auto by_time = [](const auto& sample) { return sample.header.time_ns; };
    give_up_to(scenes, exposure_ns, by_time);
    give_up_to(states, exposure_ns, by_time);
    step(made.header.time_ns);
  }

  void at(std::int64_t time_ns) {
    newest_ns = time_ns;
    const double whole = std::max(overview.duration(), 1e-9);
    progress.update(std::clamp(seconds(time_ns - overview.begin_ns) / whole, 0.0, 1.0),
                    fmt::format("{:.1f} of {:.1f} s", seconds(time_ns - overview.begin_ns), whole));
    if (realtime) return;
    while (next_step_ns < time_ns) {
      step(next_step_ns);
      next_step_ns = cycle_of((next_step_ns / alone.period_ns() + 1) * alone.period_ns());
    }
  }

  void step(std::int64_t now_ns) {
    while (!asked.empty() && asked.begin()->first <= now_ns) {
      std::visit([this](const auto& sample) { alone.give(sample); }, asked.begin()->second->sample);
      asked.erase(asked.begin());
    }
    alone.step(now_ns);
    for_each([this](auto& topic) { judge_given(topic); });
    for_each([this](auto& topic) { give_up(topic, newest_ns - kPatience_ns); });
  }

  template <typename T>
  void judge_recorded(const T& sample) {
    auto& topic = *std::get<std::optional<Answers<T>>>(answers);
    const auto key = key_of(sample, newest_recorded);
    if (!key) return;
    ++result.topics[topic.index].recorded;
    topic.last_recorded = std::max(topic.last_recorded, *key);
    const auto other = topic.given.find(*key);
    if (other == topic.given.end()) {
      topic.recorded.insert_or_assign(*key, sample);
      return;
    }
    judge(topic, sample, other->second);
    topic.given.erase(other);
  }
  template <typename T>
  void judge_given(Answers<T>& topic) {
    T sample{};
    while (topic.reader.take(sample)) {
      const auto key = key_of(sample, newest_given);
      if (!key) continue;
      const auto other = topic.recorded.find(*key);
      if (other == topic.recorded.end()) {
        topic.given.insert_or_assign(*key, sample);
        continue;
      }
      judge(topic, other->second, sample);
      topic.recorded.erase(other);
    }
  }
  /// What is alone up to that time stays so.
  template <typename T>
  void give_up(Answers<T>& topic, std::int64_t until_ns) {
    const auto end = [until_ns](auto& of) { return of.lower_bound(Key{until_ns}); };
    for (auto i = topic.recorded.begin(); i != end(topic.recorded); i = topic.recorded.erase(i))
      tell_first(topic, i->second, "it is in the recording alone");
    for (auto i = topic.given.begin(); i != end(topic.given); i = topic.given.erase(i)) {
      // when the recording ended there was no answer yet; in realtime one may have been lost
      if (realtime || i->first > topic.last_recorded) continue;
      ++result.topics[topic.index].given;
      tell_first(topic, i->second, "it is not in the recording");
    }
  }

  template <typename T>
  void judge(Answers<T>& topic, const T& recorded, T given) {
    TopicResult& of = result.topics[topic.index];
    ++of.given;
    // vision's estimate is sent when it is done
    if constexpr (!std::is_same_v<T, wire::Plan> && !std::is_same_v<T, wire::PlannerDebug>)
      if (realtime) given.header.time_ns = recorded.header.time_ns;
    const std::vector<Difference> found = differences(recorded, given);
    if (found.empty()) {
      ++of.same;
      return;
    }
    const Difference& first = found.front();
    const auto word = [](const std::string& text) { return text.empty() ? "nothing" : text; };
    tell_first(topic, recorded,
               fmt::format("{}: recorded {}, given {}", first.field, word(first.recorded),
                           word(first.given)));
    std::map<std::string, double> by_field;
    for (const Difference& difference : found) {
      double& largest = by_field[without_places(difference.field)];
      largest = std::max(largest, difference.amount);
    }
    for (const auto& [field, amount] : by_field)
      count(of.topic, field, amount, recorded.header.seq);
  }
  void count(const std::string& topic, const std::string& field, double amount, std::uint64_t seq) {
    const auto known = std::find_if(
        result.fields.begin(), result.fields.end(),
        [&](const FieldResult& each) { return each.topic == topic && each.field == field; });
    FieldResult& of = known != result.fields.end()
                          ? *known
                          : result.fields.emplace_back(FieldResult{topic, field, 0, 0.0, seq});
    ++of.answers;
    if (amount > of.largest) {
      of.largest = amount;
      of.largest_seq = seq;
    }
  }
  template <typename T>
  void tell_first(const Answers<T>& topic, const T& sample, const std::string& what) {
    if (!result.first.empty()) return;
    result.first =
        fmt::format("{} {} ({:.4f} s): {}", result.topics[topic.index].topic, sample.header.seq,
                    seconds(sample.header.time_ns - overview.begin_ns), what);
  }

  const wire::Process process;
  const Overview& overview;
  const bool realtime;
  const std::int64_t publish_delay_ns;
  const InOrder::Shifts shifts;
  Alone alone;
  std::multimap<std::int64_t, const Asked*> asked;  // by when it is taken
  std::int64_t next_step_ns;                        // lockstep
  std::int64_t newest_ns = 0;
  std::int64_t exposure_ns = 0;  // realtime: of vision's newest answer
  std::deque<wire::RobotState> states;
  std::deque<wire::Scene> scenes;
  std::deque<wire::ObjectEstimate> estimates;
  AllAnswers<AnswerTypes>::Type answers;
  NewestPlan newest_recorded, newest_given;
  ComparisonResult result;
  Progress progress{"replay"};
};

Comparison::Comparison(const config::Scenario& scenario, wire::Process process, std::uint64_t seed,
                       const Overview& overview, bool realtime)
    : implementation_(
          std::make_unique<Implementation>(scenario, process, seed, overview, realtime)) {}
Comparison::~Comparison() = default;

const InOrder::Shifts& Comparison::shifts() const { return implementation_->shifts; }
void Comparison::at(std::int64_t time_ns) { implementation_->at(time_ns); }
bool Comparison::has_enough() const { return wire::StopFlag::requested(); }
#define C3RT_TOPIC(Type, ...) \
  void Comparison::hear(const wire::Type& sample) { implementation_->take(sample); }
C3RT_TOPICS(C3RT_TOPIC)
#undef C3RT_TOPIC

const ComparisonResult& Comparison::finish() {
  Implementation& self = *implementation_;
  self.at(self.newest_ns + 1);
  self.for_each(
      [&self](auto& topic) { self.give_up(topic, std::numeric_limits<std::int64_t>::max()); });
  return self.result;
}

}  // namespace c3rt::cli::replay
