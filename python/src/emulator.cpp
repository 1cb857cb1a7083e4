// A scenario's arm, table and objects in simulated time, under the impedance controller and the
// robot's own guard, without a planner: what c3rt.envs is made of. No bus, no clock, no thread.
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/stl/vector.h>

#include "cli/paths.hpp"
#include "config/scenario.hpp"
#include "controller/base/time.hpp"
#include "controller/impedance/node.hpp"
#include "controller/task/task.hpp"
#include "idl/convert.hpp"
#include "plant_emulator/errors.hpp"
#include "plant_emulator/node.hpp"
#include "plant_emulator/top_view.hpp"
#include "python/src/arrays.hpp"
#include "python/src/bind.hpp"

namespace c3rt::python {
namespace {

using namespace nb::literals;

constexpr std::int64_t kWatchNs = 10'000'000;  // the task is looked at as a run's report does

class Emulator {
 public:
  Emulator(const std::string& scenario, const std::vector<std::string>& overrides)
      : scenario_(config::load_scenario(cli::scenario_path(scenario).string(), overrides)),
        task_(scenario_.task.motion) {
    begin(1);
  }

  /// As `c3rt run --seed SEED` begins.
  void begin(std::uint64_t seed) {
    plant_.emplace(scenario_.plant, scenario_.vision.rate, seed);
    servo_.emplace(scenario_.impedance, model::Arm(scenario_.impedance.arm));
    task_ = scenario_.task.motion.seeded(seed);
    progress_ = task_.progress();
    state_ = {};
    state_.since = 0.0;
    command_seq_ = plan_seq_ = 0;
    begun_ns_ = now_ns_ = plant::kCycleNs;  // 0 means "none" in a stamp
    take(plant_->start(now_ns_));
    p_WE_before_ = plant().p_WE;
    watch();
  }

  /// The end effector is asked to go straight from one point to another, in W [m], in so long [s].
  void move(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double duration) {
    const nb::gil_scoped_release others_run;
    const std::int64_t until_ns = now_ns_ + base::nanoseconds(duration);
    const wire::Plan plan = motion(from, to, until_ns);
    for (const wire::Plan* news = &plan; now_ns_ < until_ns; news = nullptr) {
      impedance::Node::Input in;
      in.state = &robot_;
      in.plan = news;
      const impedance::Node::Output& out = servo_->step(now_ns_, in);
      wire::RobotCommand command = out.command;
      command.header = {kSession, ++command_seq_, now_ns_};
      p_WE_before_ = plant().p_WE;
      now_ns_ += plant::kCycleNs;
      take(plant_->step(now_ns_, out.commands ? &command : nullptr, nullptr));
      if ((now_ns_ - begun_ns_) % kWatchNs == 0) watch();
    }
  }

  double elapsed() const { return base::seconds(now_ns_ - begun_ns_); }
  double amount() const { return progress_->amount(); }
  /// Where a run would end by itself.
  bool done() const { return progress_->completed() >= scenario_.task.loops; }

  /// Why the arm no longer follows; empty: it does.
  std::string stopped() const {
    const plant::State& now = plant();
    if (now.mode == plant::Mode::kIdle || now.mode == plant::Mode::kMove) return "";
    const std::string cause = plant::text(now.cause);
    return plant::names(now.errors) + (cause.empty() ? "" : " (" + cause + ")");
  }

  /// The first object that is where the planner would no longer work with it; -1: none.
  int out_of_reach() const {
    const auto& reach = scenario_.planner.approach;
    for (int i = 0; i < plant().object_count; ++i) {
      const Eigen::Vector2d at = object(i).p_WB.head<2>();
      if ((at.array() < reach.reach_min.array()).any() ||
          (at.array() > reach.reach_max.array()).any())
        return i;
    }
    return -1;
  }

  /// [p_WE; v_WE], the velocity over the last cycle
  Eigen::VectorXd effector() const {
    Eigen::VectorXd out(6);
    out << plant().p_WE, (plant().p_WE - p_WE_before_) / plant::kCycle;
    return out;
  }
  /// One column [p; q; v; omega] each
  Eigen::MatrixXd objects() const {
    Eigen::MatrixXd out(13, plant().object_count);
    for (int i = 0; i < plant().object_count; ++i) {
      const scene::Body& body = object(i);
      out.col(i) << body.p_WB, body.q_WB.w(), body.q_WB.x(), body.q_WB.y(), body.q_WB.z(),
          body.v_WB, body.omega_WB;
    }
    return out;
  }
  /// One column [x; y; turn about z to go; error of place; error of orientation] each
  Eigen::MatrixXd targets() const {
    const scene::Scene scene = seen();
    Eigen::MatrixXd out(5, scene.body_count);
    for (int i = 0; i < scene.body_count; ++i) {
      const scene::Body& body = scene.body(i);
      const Eigen::Vector2d at = task_.target(scene, i, elapsed(), 0.0, state_);
      const std::optional<task::Goal> goal = task_.goal(state_, i);
      out.col(i) << at, 0.0, task_.error(elapsed(), body.p_WB.head<2>(), i), 0.0;
      if (!goal) continue;
      out(2, i) = goal->turn_about_z(body);
      out(3, i) = (body.p_WB.head<2>() - goal->at).norm();
      out(4, i) = angle_error(*goal, body);
    }
    return out;
  }
  Eigen::MatrixXd workspace() const {
    Eigen::MatrixXd out(3, 2);
    out << scenario_.impedance.limits.workspace_min, scenario_.impedance.limits.workspace_max;
    return out;
  }
  Eigen::MatrixXd reach() const {
    Eigen::MatrixXd out(2, 2);
    out << scenario_.planner.approach.reach_min, scenario_.planner.approach.reach_max;
    return out;
  }
  double duration() const { return scenario_.task.duration_s; }
  /// A plan is followed no longer.
  double longest() const { return scenario_.impedance.limits.plan_timeout; }
  std::string describe() const { return task_.describe(); }

  nb::object picture(int width, int height) const {
    const Eigen::AlignedBox2d of(scenario_.planner.approach.reach_min,
                                 scenario_.planner.approach.reach_max);
    auto* pixels =
        new std::vector<std::uint8_t>(plant::top_view(plant_->plant(), of, width, height));
    const nb::capsule owner(pixels, [](void* memory) noexcept {
      delete static_cast<std::vector<std::uint8_t>*>(memory);
    });
    return nb::cast(nb::ndarray<nb::numpy, std::uint8_t>(
        pixels->data(), {static_cast<std::size_t>(height), static_cast<std::size_t>(width), 3},
        owner));
  }

 private:
  static constexpr std::uint64_t kSession = 1;

  const plant::State& plant() const { return plant_->plant().state(); }
  const scene::Body& object(int i) const { return plant().objects[static_cast<std::size_t>(i)]; }

  static double angle_error(const task::Goal& goal, const scene::Body& body) {
    const Eigen::Quaterniond now(body.q_WB);
    if (goal.axis) {
      const Eigen::Vector3d axis = now * goal.axis->of_body;
      return std::atan2(axis.cross(goal.axis->to).norm(), axis.dot(goal.axis->to));
    }
    if (!goal.yaw) return 0.0;
    return now.angularDistance(
        Eigen::Quaterniond(Eigen::AngleAxisd(*goal.yaw, Eigen::Vector3d::UnitZ())));
  }

  wire::Plan motion(const Eigen::Vector3d& from, const Eigen::Vector3d& to, std::int64_t until_ns) {
    wire::Plan plan{};
    plan.header = {kSession, ++plan_seq_, now_ns_};
    plan.valid_until_ns = until_ns;
    plan.status = c3rt_v2_PLAN_OK;
    wire::set_text(plan.phase, "move");
    plan.knot_count = 2;
    const Eigen::Vector3d v = (to - from) / base::seconds(until_ns - now_ns_);
    const auto knot = [&](c3rt_v2_Knot& out, std::int64_t time_ns, const Eigen::Vector3d& p) {
      out.time_ns = time_ns;
      wire::fill(out.p_WE_m, p);
      wire::fill(out.v_WE_m_per_s, v);
      wire::fill(out.q_WE, Eigen::Quaterniond(0.0, 1.0, 0.0, 0.0));  // the tool points down
    };
    knot(plan.knots[0], now_ns_, from);
    knot(plan.knots[1], until_ns, to);
    return plan;
  }

  void take(const plant::Node::Output& out) {
    robot_ = out.state;
    robot_.header = {kSession, static_cast<std::uint64_t>(now_ns_ / plant::kCycleNs), now_ns_};
  }

  scene::Scene seen() const {
    scene::Scene scene;
    scene.effector.p_WE = plant().p_WE;
    scene.table_height = scenario_.plant.world.table_height;
    scene.body_count = plant().object_count;
    for (int i = 0; i < scene.body_count; ++i) scene.body(i) = object(i);
    return scene;
  }

  void watch() {
    std::vector<task::Placement> placed;
    for (int i = 0; i < plant().object_count; ++i)
      placed.emplace_back(object(i).p_WB.head<2>(), object(i).q_WB);
    progress_->add(elapsed(), placed);
    task_.advance(elapsed(), seen(), state_);
  }

  const config::Scenario scenario_;
  std::optional<plant::Node> plant_;
  std::optional<impedance::Node> servo_;
  task::Task task_;
  std::unique_ptr<task::Progress> progress_;
  task::State state_;
  wire::RobotState robot_{};
  Eigen::Vector3d p_WE_before_ = Eigen::Vector3d::Zero();
  std::int64_t now_ns_ = 0, begun_ns_ = 0;
  std::uint64_t command_seq_ = 0, plan_seq_ = 0;
};

Eigen::Vector3d point(nb::handle of, const char* name) { return vector(of, name, 3); }

}  // namespace

void bind_emulator(nb::module_& module) {
  nb::class_<Emulator>(module, "Emulator",
                       "A scenario's arm, table and objects under the impedance controller; "
                       "c3rt.envs is made of it.")
      .def(nb::init<const std::string&, const std::vector<std::string>&>(), "scenario"_a,
           "overrides"_a = std::vector<std::string>())
      .def("begin", &Emulator::begin, "seed"_a, "As c3rt run --seed SEED begins.")
      .def(
          "move",
          [](Emulator& self, nb::handle start, nb::handle end, double duration_s) {
            if (!(duration_s >= 1e-3 && duration_s <= self.longest()))
              throw std::invalid_argument("duration_s: expected a number from 0.001 to " +
                                          std::to_string(self.longest()) + ", got " +
                                          std::to_string(duration_s));
            self.move(point(start, "start"), point(end, "end"), duration_s);
          },
          "start"_a, "end"_a, "duration_s"_a,
          nb::sig("def move(self, start: numpy.typing.ArrayLike, end: numpy.typing.ArrayLike, "
                  "duration_s: float) -> None"),
          "Asks the end effector to go straight from start to end in that time.")
      .def_prop_ro("elapsed_s", &Emulator::elapsed)
      .def_prop_ro("duration_s", &Emulator::duration, "Of the scenario's task.")
      .def_prop_ro("task", &Emulator::describe, "The task in words.")
      .def_prop_ro("longest_s", &Emulator::longest, "Of a motion.")
      .def_prop_ro("progress", &Emulator::amount, "Of the task: goals, rounds, objects arrived.")
      .def_prop_ro("done", &Emulator::done, "Whether a run would end by itself.")
      .def_prop_ro("stopped", &Emulator::stopped, "What has stopped the arm; empty: nothing.")
      .def_prop_ro("out_of_reach", &Emulator::out_of_reach,
                   "The first object that is out of the planner's reach; -1: none.")
      .def_prop_ro(
          "effector", [](const Emulator& self) { return copy(self.effector()); },
          nb::sig("def effector(self) -> numpy.typing.NDArray[numpy.float64]"),
          "(6,): position [m] and velocity [m/s]")
      .def_prop_ro(
          "objects", [](const Emulator& self) { return copy_stages(self.objects()); },
          nb::sig("def objects(self) -> numpy.typing.NDArray[numpy.float64]"),
          "(n, 13): position, orientation w x y z, velocity, angular velocity")
      .def_prop_ro(
          "targets", [](const Emulator& self) { return copy_stages(self.targets()); },
          nb::sig("def targets(self) -> numpy.typing.NDArray[numpy.float64]"),
          "(n, 5): x, y, turn about z to go, error of place, error of orientation")
      .def_prop_ro(
          "workspace", [](const Emulator& self) { return copy_stages(self.workspace()); },
          nb::sig("def workspace(self) -> numpy.typing.NDArray[numpy.float64]"),
          "(2, 3): the corners of the box that the end effector is kept in")
      .def_prop_ro(
          "reach", [](const Emulator& self) { return copy_stages(self.reach()); },
          nb::sig("def reach(self) -> numpy.typing.NDArray[numpy.float64]"),
          "(2, 2): the corners of the part of the table that the planner works on")
      .def("picture", &Emulator::picture, "width"_a, "height"_a,
           nb::sig("def picture(self, width: int, height: int) -> "
                   "numpy.typing.NDArray[numpy.uint8]"),
           "(height, width, 3): reach from above, x to the top and y to the left.");
}

}  // namespace c3rt::python
