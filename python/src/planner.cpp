// The sampling strategy's planner as a function of scene and goal: no bus, no clock, no thread.
#include "controller/planner/planner.hpp"

#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/stl/vector.h>

#include "cli/paths.hpp"
#include "config/scenario.hpp"
#include "controller/model/arm.hpp"
#include "python/src/arrays.hpp"
#include "python/src/bind.hpp"

namespace c3rt::python {
namespace {

using namespace nb::literals;

/// What a period has decided.
struct Planned {
  planner::Plan plan;
  std::string words;
};

class SamplingPlanner {
 public:
  SamplingPlanner(const std::string& scenario, const std::vector<std::string>& overrides,
                  std::uint64_t seed)
      : scenario_(config::load_scenario(cli::scenario_path(scenario).string(), overrides)),
        parameters_(of_sampling(scenario_, seed)),
        limits_(planner::target_limits(parameters_)),
        planner_(parameters_),
        arm_(scenario_.impedance.arm) {}

  /// The task in words.
  std::string target(const task::Request& request) {
    planner::Target target = planner::load_target(request);
    if (auto* task = std::get_if<task::Task>(&target))
      *task = task->seeded(parameters_.sampling.seed);
    const std::string refused = planner::refusal(target, limits_);
    if (!refused.empty()) throw std::invalid_argument(refused);
    target_ = target;
    return planner::describe(target_);
  }

  Planned step(planner::Input input) {
    const nb::gil_scoped_release others_run;
    input.target = target_;
    input.solve_time = scenario_.timing.solve_time_s;
    Planned planned{planner_.step(input), {}};
    planned.words = planner::describe(planner_.activity(), parameters_, input.now);
    if (*planner_.failure() != '\0' && planner_.counters().failures != failures_)
      planned.words = planner_.failure();
    failures_ = planner_.counters().failures;
    return planned;
  }

  /// [p_WE; v_WE] of the scenario's arm
  Eigen::VectorXd effector(const Eigen::VectorXd& q, const Eigen::VectorXd& dq) {
    model::ArmState state;
    arm_.update(q, dq, state);
    Eigen::VectorXd out(6);
    out << state.X_WE.translation(), state.V_WE.head<3>();
    return out;
  }

  int bodies() const { return parameters_.model.bodies; }
  double rate() const { return parameters_.rate; }
  std::vector<std::string> objects() const {
    std::vector<std::string> names;
    for (const plant::ObjectParameters& object : scenario_.plant.world.objects)
      names.push_back(object.object.name);
    return names;
  }

 private:
  static planner::Parameters of_sampling(const config::Scenario& scenario, std::uint64_t seed) {
    if (scenario.planner.strategy != "sampling") {
      throw std::invalid_argument(
          "scenario: expected one of the strategy sampling, as push_t, got " + scenario.name +
          " of the strategy " + scenario.planner.strategy);
    }
    return planner::seeded(scenario.planner, seed);
  }

  const config::Scenario scenario_;
  const planner::Parameters parameters_;
  const task::Limits limits_;
  planner::Planner planner_;
  model::Arm arm_;
  planner::Target target_ = planner::ScenarioTarget{};
  std::uint64_t failures_ = 0;
};

/// A task's parameters, by the keys of a scenario's section `task`.
task::Request request_of(const std::string& kind, const nb::kwargs& given) {
  task::Request request{kind, {}};
  for (const auto& [key, value] : given) {
    const auto name = nb::cast<std::string>(key);
    if (nb::isinstance<nb::str>(value)) {
      request.parameters.push_back({name, {}, nb::cast<std::string>(value)});
    } else {
      request.parameters.push_back({name, numbers(value, name).values, ""});
    }
  }
  return request;
}

/// One row an object: [p; q; v; omega].
void set_bodies(planner::Input& input, int bodies, nb::handle objects, nb::handle ages,
                nb::handle seen) {
  const Eigen::MatrixXd rows = matrix(objects, "objects", bodies, 13);
  Eigen::VectorXd age = Eigen::VectorXd::Zero(bodies), view = Eigen::VectorXd::Ones(bodies);
  if (!ages.is_none()) age = vector(ages, "ages", bodies);
  if (!seen.is_none()) view = vector(seen, "seen", bodies);
  for (int i = 0; i < bodies; ++i) {
    planner::BodyInput& body = input.bodies[static_cast<std::size_t>(i)];
    const Eigen::VectorXd row = rows.row(i);
    if (!(row.segment<4>(3).norm() > 1e-9))
      throw std::invalid_argument("objects: expected quaternions w x y z, got zeros");
    body.seen = view[i] != 0.0;
    body.age = age[i];
    body.body.p_WB = row.head<3>();
    body.body.q_WB = Eigen::Quaterniond(row[3], row[4], row[5], row[6]);
    body.body.v_WB = row.segment<3>(7);
    body.body.omega_WB = row.segment<3>(10);
  }
}

Planned step(SamplingPlanner& self, double time_s, nb::handle effector, nb::handle objects,
             nb::handle ages, nb::handle seen, bool follows, bool stopped) {
  planner::Input input{};
  input.now = time_s;
  input.robot_follows = follows;
  input.stopped = stopped;
  input.state_age = std::numeric_limits<double>::infinity();
  if (!effector.is_none()) {
    const Eigen::VectorXd of = vector(effector, "effector", 6);
    input.state_age = 0.0;
    input.effector.p_WE = of.head<3>();
    input.effector.v_WE = of.tail<3>();
  }
  if (!objects.is_none()) set_bodies(input, self.bodies(), objects, ages, seen);
  return self.step(input);
}

const char* status_of(const Planned& self) {
  switch (self.plan.status) {
    case planner::PlanStatus::kOk:
      return "ok";
    case planner::PlanStatus::kTruncated:
      return "truncated";
    case planner::PlanStatus::kFallback:
      break;
  }
  return "fallback";
}

Eigen::VectorXd of_weighed(const Planned& self, double (*value)(const planner::WeighedPlace&)) {
  Eigen::VectorXd out(static_cast<Eigen::Index>(self.plan.weighed.size()));
  for (Eigen::Index i = 0; i < out.size(); ++i)
    out[i] = value(self.plan.weighed[static_cast<std::size_t>(i)]);
  return out;
}

void bind_planned(nb::module_& module) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const auto vector_sig = [](const char* name) {
    return "def " + std::string(name) + "(self) -> numpy.typing.NDArray[numpy.float64]";
  };
  static const std::string candidates = vector_sig("candidates"), costs = vector_sig("costs"),
                           gains = vector_sig("gains"), target = vector_sig("target"),
                           p = vector_sig("p"), v = vector_sig("v"), q = vector_sig("q"),
                           force = vector_sig("force"), x = vector_sig("x"), u = vector_sig("u"),
                           lam = vector_sig("lam");
  nb::class_<Planned>(module, "SamplingPlan", "What a period of a SamplingPlanner has decided.")
      .def_prop_ro("status", &status_of, "ok, truncated or fallback: then the arm is held.")
      .def_prop_ro(
          "phase", [](const Planned& self) { return self.plan.phase; },
          "approach until it first pushes, then choose, move, push or stand; wait and hold where "
          "it is "
          "not at its task.")
      .def_prop_ro(
          "words", [](const Planned& self) { return self.words; },
          "What it does and why, as c3rt status has it.")
      .def_prop_ro(
          "object", [](const Planned& self) { return self.plan.body; },
          "That is worked on, by its index in the scenario.")
      .def_prop_ro(
          "target", [](const Planned& self) { return copy(self.plan.body_target); },
          nb::sig(target.c_str()), "(3,): where that is wanted [m]")
      .def_prop_ro(
          "place",
          [](const Planned& self) -> nb::object {
            if (!self.plan.place) return nb::none();
            return copy(*self.plan.place);
          },
          nb::sig("def place(self) -> numpy.typing.NDArray[numpy.float64] | None"),
          "(3,): the chosen one, to which the end effector goes or from which it pushes [m]; None: "
          "none is")
      .def_prop_ro(
          "candidates",
          [](const Planned& self) {
            Eigen::MatrixXd out(3, static_cast<Eigen::Index>(self.plan.weighed.size()));
            for (Eigen::Index i = 0; i < out.cols(); ++i)
              out.col(i) = self.plan.weighed[static_cast<std::size_t>(i)].p_WE;
            return copy_stages(out);
          },
          nb::sig(candidates.c_str()),
          "(k, 3): the places that were weighed in this period [m]; while it moves or pushes the "
          "first is where it goes or is")
      .def_prop_ro(
          "candidate_objects",
          [](const Planned& self) {
            std::vector<int> out;
            for (const planner::WeighedPlace& place : self.plan.weighed) out.push_back(place.body);
            return out;
          },
          "Beside which object each of them is.")
      .def_prop_ro(
          "costs",
          [](const Planned& self) {
            return copy(of_weighed(self, [](const planner::WeighedPlace& place) {
              return place.known ? place.cost : kNone;
            }));
          },
          nb::sig(costs.c_str()),
          "(k,): of the objects over the horizon, where the plan from each is tried in a roll-out; "
          "inf: it has no answer, or leads out of reach")
      .def_prop_ro(
          "gains",
          [](const Planned& self) {
            return copy(of_weighed(self, [](const planner::WeighedPlace& place) {
              return place.known ? place.still - place.cost : 0.0;
            }));
          },
          nb::sig(gains.c_str()), "(k,): what that is less than the cost of touching nothing")
      .def_prop_ro(
          "p", [](const Planned& self) { return copy(self.plan.p_WE); }, nb::sig(p.c_str()),
          "(3,): where the end effector shall be, delta_t_c_s after the plan takes effect [m]")
      .def_prop_ro(
          "v", [](const Planned& self) { return copy(self.plan.v_WE); }, nb::sig(v.c_str()),
          "(3,): and how fast [m/s]")
      .def_prop_ro(
          "q",
          [](const Planned& self) {
            const Eigen::Quaterniond& of = self.plan.q_WE;
            return copy(Eigen::VectorXd(Eigen::Vector4d(of.w(), of.x(), of.y(), of.z())));
          },
          nb::sig(q.c_str()), "(4,): its orientation, w x y z")
      .def_prop_ro(
          "force", [](const Planned& self) { return copy(self.plan.force_E); },
          nb::sig(force.c_str()), "(3,): of the contacts on it [N]")
      .def_prop_ro(
          "delta_t_c_s", [](const Planned& self) { return self.plan.delta_t_c; },
          "Of Algorithm 3; 0 where C3 does not plan, and then x, lam and u are zeros.")
      .def_prop_ro(
          "x", [](const Planned& self) { return copy_stages(self.plan.x); }, nb::sig(x.c_str()),
          "(N, n_x): predicted")
      .def_prop_ro(
          "lam", [](const Planned& self) { return copy_stages(self.plan.lambda); },
          nb::sig(lam.c_str()), "(N, n_lambda): forces of the planning model [N]")
      .def_prop_ro(
          "u", [](const Planned& self) { return copy_stages(self.plan.u); }, nb::sig(u.c_str()),
          "(N, n_u): inputs [N]");
}

}  // namespace

void bind_planner(nb::module_& module) {
  bind_planned(module);
  nb::class_<SamplingPlanner>(
      module, "SamplingPlanner",
      "The planner of a scenario of the strategy sampling, as c3rt-planner has it: places drawn "
      "around an object, ranked by roll-outs of the plans from there, and the way to the best of "
      "them. The same input gives the same bits.")
      .def(nb::init<const std::string&, const std::vector<std::string>&, std::uint64_t>(),
           "scenario"_a, "overrides"_a = std::vector<std::string>(), "seed"_a = 1,
           "scenario: a name or a file; overrides: \"planner.rate_hz=50\"; seed: of what is drawn.")
      .def_prop_ro("objects", &SamplingPlanner::objects, "Their names, in the scenario's order.")
      .def_prop_ro("rate_hz", &SamplingPlanner::rate, "Of its periods.")
      .def(
          "target",
          [](SamplingPlanner& self, const std::string& kind, const nb::kwargs& parameters) {
            return self.target(request_of(kind, parameters));
          },
          "kind"_a, "parameters"_a,
          nb::sig("def target(self, kind: str, **parameters: typing.Any) -> str"),
          "The goal from now on, as of c3rt target: target(\"pose\", goals_m=[[0.55, 0.05]], "
          "yaws_rad=0, ...), \"scenario\", \"hold\". Returns the task in words. ValueError "
          "says what cannot be reached or done.")
      .def(
          "effector",
          [](SamplingPlanner& self, nb::handle q, nb::handle dq) {
            return copy(self.effector(vector(q, "q", 7), vector(dq, "dq", 7)));
          },
          "q"_a, "dq"_a,
          nb::sig("def effector(self, q: numpy.typing.ArrayLike, dq: numpy.typing.ArrayLike) -> "
                  "numpy.typing.NDArray[numpy.float64]"),
          "(6,): position [m] and velocity [m/s] of the end effector, from the arm's joints [rad, "
          "rad/s]")
      .def("step", &step, "time_s"_a, "effector"_a.none(), "objects"_a.none(),
           "ages"_a = nb::none(), "seen"_a = nb::none(), "follows"_a = true, "stopped"_a = false,
           nb::sig("def step(self, time_s: float, effector: numpy.typing.ArrayLike | None, "
                   "objects: numpy.typing.ArrayLike | None, ages: numpy.typing.ArrayLike | None = "
                   "None, seen: numpy.typing.ArrayLike | None = None, follows: bool = True, "
                   "stopped: bool = False) -> SamplingPlan"),
           "One period. effector: (6,), position [m] and velocity [m/s]; objects: (n, 13), "
           "position, orientation w x y z, velocity, angular velocity in W; ages: (n,), since each "
           "was seen [s]; seen: (n,), 0 of one that is lost; follows: the arm tracks the plans. "
           "None: not known.");
}

}  // namespace c3rt::python
