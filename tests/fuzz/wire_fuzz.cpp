// What may come from the network: any sample of any topic is refused with a sentence, or can be
// used without looking again. An input names a topic; its other lines change a sample that would be
// let in: "knots.p_WE_m 4 nan" is the second number of the second knot.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <string>
#include <type_traits>

#include "controller/impedance/controller.hpp"
#include "controller/planner/adjustable_weights.hpp"
#include "controller/planner/target.hpp"
#include "idl/convert.hpp"
#include "idl/validate.hpp"
#include "tests/idl/samples.hpp"

namespace {

using namespace c3rt;

void require(bool holds, const char* promise, const std::string& of) {
  if (holds) return;
  std::fprintf(stderr, "broken promise: %s: %s\n", promise, of.c_str());
  std::abort();
}

/// Writes one number or text into a sample; what it does not have stays out.
class Change {
 public:
  Change(std::string path, long index, std::string value)
      : path_(std::move(path)), index_(index), value_(std::move(value)) {}

  template <typename T>
  void operator()(const char* name, T& value) {
    const std::string outer = here_;
    here_ += here_.empty() ? name : std::string(".") + name;
    set(value);
    here_ = outer;
  }
  template <typename T, std::size_t n>
  void list(const char* name, T (&values)[n], int) {
    (*this)(name, values);
  }
  void machine_time(const char* name, double& value) { (*this)(name, value); }

 private:
  template <typename T>
  void set(T& value) {
    if constexpr (std::is_array_v<T> && std::is_same_v<std::remove_extent_t<T>, char>) {
      // the end may be missing: that is for the reader to see
      if (found()) std::memcpy(value, value_.data(), std::min(sizeof value, value_.size() + 1));
    } else if constexpr (std::is_array_v<T>) {
      for (auto& element : value) set(element);
    } else if constexpr (std::is_class_v<T>) {
      wire::visit_fields(value, *this);
    } else if (found()) {
      if constexpr (std::is_floating_point_v<T>) {
        value = std::strtod(value_.c_str(), nullptr);
      } else {
        // also an enumerator or a truth value that is none
        const long long whole = std::strtoll(value_.c_str(), nullptr, 0);
        std::memcpy(&value, &whole, sizeof value);
      }
    }
  }
  bool found() { return here_ == path_ && index_-- == 0; }

  std::string path_, here_;
  long index_;
  std::string value_;
};

/// What a reader relies on, written once more: numbers are finite, enumerators and truth values
/// exist, texts end.
struct Sound {
  template <typename T>
  void operator()(const char* name, const T& value) {
    if constexpr (std::is_array_v<T> && std::is_same_v<std::remove_extent_t<T>, char>) {
      require(std::memchr(value, '\0', sizeof value) != nullptr, "a text ends", name);
    } else if constexpr (std::is_array_v<T>) {
      for (const auto& element : value) (*this)(name, element);
    } else if constexpr (std::is_same_v<T, wire::Header>) {
      require(value.seq >= 1, "the sequence begins at 1", name);
    } else if constexpr (std::is_class_v<T>) {
      wire::visit_fields(value, *this);
    } else if constexpr (std::is_floating_point_v<T>) {
      require(std::isfinite(value), "a number is finite", name);
    } else if constexpr (std::is_enum_v<T>) {
      require(std::strcmp(wire::name_of(value), "?") != 0, "an enumerator has a name", name);
    } else if constexpr (std::is_same_v<T, bool>) {
      unsigned char raw = 0;
      std::memcpy(&raw, &value, 1);
      require(raw <= 1, "a truth value is one", name);
    }
  }
  template <typename T, std::size_t n>
  void list(const char* name, const T (&values)[n], int count) {
    require(count >= 0 && count <= static_cast<int>(n), "a count fits its array", name);
    for (int i = 0; i < count; ++i) (*this)(name, values[i]);
  }
  void machine_time(const char* name, double value) { (*this)(name, value); }
};

template <typename T>
void use(const T&) {}

void use(const wire::RobotState& sample) {
  struct {
    std::uint64_t session_id;
    std::int64_t state_stamp_ns;
    Eigen::Matrix<double, 7, 1> q, dq;
    bool robot_moves;
  } input{};
  wire::read_robot_state(sample, input);
  require(input.q.allFinite() && input.dq.allFinite(), "joints are finite", "robot/state");
}

void use(const wire::Plan& sample) {
  impedance::Plan plan;
  wire::read_plan(sample, plan);
  require(plan.knot_count >= 1, "a plan has a knot", "plan");
  for (int i = 0; i < plan.knot_count; ++i) {
    const auto& knot = plan.knots[static_cast<std::size_t>(i)];
    require(std::abs(knot.q_WE.norm() - 1.0) < 0.02, "a knot is turned", "plan");
    require(i == 0 || knot.time_ns > plan.knots[static_cast<std::size_t>(i) - 1].time_ns,
            "knots follow one another", "plan");
  }
}

void use(const wire::Scene& sample) {
  for (int i = 0; i < sample.object_count; ++i)
    require(std::abs(wire::body(sample.objects[i]).q_WB.norm() - 1.0) < 0.02, "a body is turned",
            "sim/scene");
}

void use(const wire::TaskTarget& sample) {
  try {
    const planner::Target target = planner::load_target(wire::request(sample));
    const task::Limits limits{2, {Eigen::Vector2d(0.3, -0.3), Eigen::Vector2d(0.7, 0.3)}, true};
    const std::string why = planner::refusal(target, limits);
    require(!planner::describe(target).empty(), "a target is described", "task/target");
    (void)why;
  } catch (const task::RequestError& error) {
    require(std::strlen(error.what()) > 0, "a refused target is told why", "task/target");
  }
}

void use(const wire::PlannerWeights& sample) {
  planner::Parameters scenario{};
  scenario.weights_adjustable_by = 100.0;
  scenario.roll.Q = {{"ball_xy", {5e5}}, {"ball_velocity", {0.1, 0.2}}};
  scenario.roll.R = 0.01;
  const planner::NamedWeights wanted = wire::weights(sample);
  if (!planner::refusal(wanted, planner::adjustable_weights(scenario)).empty()) return;
  const planner::Parameters others = planner::with_weights(scenario, wanted);
  const bool near = others.roll.R >= 1e-4 && others.roll.R <= 1.0 &&
                    others.roll.Q.at("ball_xy").at(0) >= 5e3 &&
                    others.roll.Q.at("ball_xy").at(0) <= 5e7;
  require(near, "weights that are taken are within the scenario's range", "planner/weights");
}

template <typename T>
void look(T& sample, std::istringstream& lines) {
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string path, value;
    long index = 0;
    if (!(words >> path >> index)) continue;
    std::getline(words >> std::ws, value);
    Change change(path, index, value);
    wire::visit_fields(sample, change);
  }
  constexpr std::int64_t kLatest_ns = 4'000'000'000'000'000'000;
  wire::Refusal refusal = wire::validate(sample.header, true, kLatest_ns);
  if (!refusal) refusal = wire::validate(sample);
  const std::string why = wire::to_text(refusal);
  require(why.empty() == !refusal, "a refusal is told, and nothing else", why);
  if (refusal) return;
  Sound sound;
  wire::visit_fields(std::as_const(sample), sound);
  use(sample);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::istringstream lines(std::string(reinterpret_cast<const char*>(data), size));
  std::string name;
  std::getline(lines, name);
#define C3RT_TOPIC(Type, ...)                         \
  if (name == #Type) {                                \
    auto sample = wire::test::plain<wire::Type>();    \
    sample.header.seq = 1;                            \
    look(sample, lines);                              \
  } else if (name == #Type " in use") {               \
    auto sample = wire::test::numbered<wire::Type>(); \
    look(sample, lines);                              \
  }
  C3RT_TOPICS(C3RT_TOPIC)
#undef C3RT_TOPIC
  return 0;
}
