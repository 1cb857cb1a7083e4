#pragma once
// Everything that the scenario says about the planner. Numbers live in YAML only; their ranges in
// load_parameters.cpp.
#include <cstdint>
#include <limits>
#include <optional>
#include <set>
#include <string>

#include <Eigen/Core>

#include "controller/c3/solver.hpp"
#include "controller/model/contact_model.hpp"
#include "controller/model/registry.hpp"
#include "controller/planner/weights.hpp"
#include "controller/task/circle.hpp"

namespace c3rt::planner {

/// The planning model M_s by name, and what of it is planned with.
struct ModelParameters {
  std::string kind;           // of model::model_kinds()
  model::ModelValues values;  // by the kind's keys
  int bodies;
  // The body that weights and lengths were tuned with has another mass: the model is built with
  // that mass, which changes no motion (all forces are proportional to it), and its forces count in
  // this unit [N].
  double force_unit = 1.0;
  // Of another size, planned with another step: λ is scaled as for those. The scale of the forces
  // of an LCS grows with the square of a body's size over the step, which would be another weight
  // on the same force.
  double force_scale_ratio = 1.0;
  model::ContactModel contact_model;  // of L_Δt; the step over Δt_c is Stewart and Trinkle's
  std::set<std::string> pairs;  // that L_Δt has, by their names; the step over Δt_c has them all
};

/// What strategies know of the world beside the bodies, which have shapes of their own.
struct Geometry {
  double end_effector_radius;  // [m]
  double table_height;         // of the table's surface in W [m]
};

/// The time-based heuristic of Figure 10: where the end effector is drawn to, never when it
/// touches.
struct HeuristicParameters {
  double roll_duration;    // Phase I [s]
  double return_duration;  // Phase II [s], three equal parts: up, sideways, down
  double roll_clearance;   // Phase I: height above touching the body from straight above [m]
  double return_back;      // Phase II: how far behind the body, seen from its target [m]
  Eigen::Vector3d return_heights;  // Phase II: up, sideways, down, above the table [m]
  // Beyond Figure 10: the arm presses down with this throughout Phase I, on top of λ_d [N]
  double roll_press = 0.0;
  // Beyond Figure 10: Phase I ends early where the body, once touched, has run away by this gap,
  // over which no force acts [m]
  double return_gap = std::numeric_limits<double>::infinity();
  // and where the end effector is farther than this from above the body: it has slipped off [m]
  double roll_reach = std::numeric_limits<double>::infinity();
  // Beyond Figure 10: Phase II is drawn to where the body will be after this time [s]
  double return_lead = 0.0;
  // and moves with the body from stage to stage of the horizon
  bool return_follows = false;
  // Beyond (25): the target is drawn no farther from the body than this, so that one that was
  // pushed away is brought back at the usual speed [m]
  double target_reach = std::numeric_limits<double>::infinity();
  // of several bodies: which one is worked on
  double look_ahead = 0.0;  // the bodies are looked at where they roll to in this time [s]
  // a body counts as this much behind, times its distance from the line
  double beside_weight = 0.0;
  double change_margin = 0.0;  // another body has to be worse off by this much [m]
  double room_ahead = 0.0;     // a body with another one ahead and nearer than this has no room [m]
};

/// The servo that a plan is tried with.
struct ServoGains {
  double stiffness;  // [N/m]
  double damping;    // [N s/m]
};

/// How a body is moved from sampled places (strategy sampling).
struct SamplingParameters {
  double height = 0.0;                   // of the end effector above the table [m]
  double clearance = 0.0;                // of a place from the body [m]
  double look_ahead = 0.0;               // the body is drawn no farther than this [m]
  double look_ahead_angle = 0.0;         // and is turned no farther [rad]
  Eigen::Vector2d reach_min, reach_max;  // no place is outside this, in W [m]
  double reach_radius;                   // or farther from the robot's base [m]
  int samples = 0;                       // places that are drawn in a period
  int samples_to_choose = 0;             // and in one in which it stands and chooses
  int least_drawn = 0;                   // before it chooses
  double better = 0.0;                   // another place has to gain this many times more
  double margin = 0.0;                   // and this part of what there is to gain
  double retarget = 0.0;      // on the way, it has to cost less than this part of the one aimed at
  double least_time = 0.0;    // at a place [s]
  double headway = 0.0;       // what is left has to fall by this part
  double headway_time = 0.0;  // within this time [s]
  double valid_moved = 0.0, valid_turned = 0.0;  // a place counts until the body has [m, rad]
  double speed = 0.0;                            // between places [m/s]
  double acceleration = 0.0;                     // [m/s²]
  double clear = 0.0;                            // from bodies on the way [m]
  bool over = true;                              // bodies, else beside them
  ServoGains servo{};
  std::uint64_t seed = 1;  // the run's
  int threads = 1;         // that places are tried by; what comes of it is the same
  PhaseWeights weights;
};

/// The way to the start pose and the behaviour when the body is lost.
struct ApproachParameters {
  double speed;         // of the end effector's reference [m/s]
  double safe_height;   // travels at this height above the table [m]
  double start_height;  // above the body's centre where C3 takes over [m]
  double tolerance;     // start pose reached [m]
  double leash;         // the reference waits for an arm that is farther behind than this [m]
  Eigen::Vector2d reach_min,
      reach_max;       // a body outside this box of the table is out of reach, in W [m]
  double settle_time;  // C3 starts after this long in the start pose with a body in view [s]
};

enum class DeltaTcSource {
  kPeriod,  // mean of the last measured control periods: the plan's age when the next one replaces
            // it
  kSolveTime,  // the time spent in steps 1 to 3, as Algorithm 3 has it
};

struct Parameters {
  double rate;               // [Hz]
  double publish_delay;      // a plan takes effect this long after the state it started from [s]
  double valid_for;          // and is valid this long [s]
  double estimate_timeout;   // a body estimate older than this counts as lost [s]
  double deadline_fraction;  // of the period, realtime only
  int N;
  double dt;                 // planning step Δt [s]
  bool scale_forces = true;  // G and U act on scaled forces (docs/math.md), else on physical ones
  ModelParameters model;
  Geometry geometry;
  std::string strategy = "time_heuristic";  // of strategy_kinds()
  c3::Settings c3;
  PhaseWeights roll, back;  // Phase I and Phase II
  // a client may multiply and divide each weight by up to this while the planner runs; 1: none
  double weights_adjustable_by = 1.0;
  HeuristicParameters heuristic;
  SamplingParameters sampling;
  ApproachParameters approach;
  task::Task task = task::Circle{};
  DeltaTcSource delta_t_c_source;
  double delta_t_c = 0.0;  // in place of what is measured; 0: none is given [s]
  double speed_limit;      // of the planned end effector [m/s]
  bool predict_objects;    // carry the estimated body on to the time of the arm's state
  bool separate_overlap;   // move an estimated body out of the end effector before linearising
  // the table is where the body lies on it, whatever height the model says: a tilt moves it by
  // millimetres
  bool table_below_object = false;
  double tilt;  // of the tool, about the axis (e_y, −e_x, 0) towards its way [rad]
};

/// The same for a run: whatever is drawn follows its seed.
inline Parameters seeded(Parameters parameters, std::uint64_t seed) {
  parameters.sampling.seed = seed;
  parameters.task = parameters.task.seeded(seed);
  return parameters;
}

}  // namespace c3rt::planner
