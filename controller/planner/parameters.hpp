#pragma once
// Everything that the scenario says about the planner. Numbers live in YAML only; their ranges in
// load_parameters.cpp.
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "controller/c3/solver.hpp"
#include "controller/model/ball_model.hpp"
#include "controller/model/balls_model.hpp"
#include "controller/planner/task.hpp"

namespace c3rt::planner {

/// Diagonal weights of one phase, by meaning. G and U act on the scaled forces (FIGURES 4.3,
/// docs/math.md).
struct PhaseWeights {
  double Q_end_effector, Q_end_effector_velocity;
  std::vector<double> Q_ball_xy;     // of the ball that is worked on, then of the others
  double Q_ball_z, Q_ball_velocity;  // z: of one ball alone
  double R;
  double G_x, G_u, G_gamma, G_end_effector_normal, G_end_effector_tangential;
  double G_table_normal, G_table_tangential;  // of one ball alone
  double G_balls_normal, G_balls_tangential;  // of several balls alone
  double U_x, U_lambda, U_u;
  // projections that need more; the convex one weighs x and u by U_x and U_u
  double convex_alpha, convex_epsilon;
  std::optional<double> plus_g_lambda;  // none: G of λ, contact by contact
  double plus_u_lambda;
  struct Gaps {  // C3+'s η by row: of the friction cone, of the distance, of the slip
    double cone, distance, slip;
  } plus_g_eta, plus_u_eta;
};

enum class ContactModel {
  kStewartTrinkle,
  kAnitescu,  // F positive semidefinite, as the convex projection needs it; λ are impulses
};

/// The time-based heuristic of Figure 10: where the end effector is drawn to, never when it
/// touches.
struct HeuristicParameters {
  double roll_duration;    // Phase I [s]
  double return_duration;  // Phase II [s], three equal parts: up, sideways, down
  double roll_clearance;   // Phase I: height above touching the ball from straight above [m]
  double return_back;      // Phase II: how far behind the ball, seen from its target [m]
  Eigen::Vector3d return_heights;  // Phase II: up, sideways, down, above the table [m]
  // Beyond Figure 10: the arm presses down with this throughout Phase I, on top of λ_d [N]
  double roll_press = 0.0;
  // Beyond Figure 10: Phase I ends early where the ball, once touched, has run away by this gap,
  // over which no force acts [m]
  double return_gap = std::numeric_limits<double>::infinity();
  // and where the end effector is farther than this from above the ball: it has slipped off [m]
  double roll_reach = std::numeric_limits<double>::infinity();
  // Beyond Figure 10: Phase II is drawn to where the ball will be after this time [s]
  double return_lead = 0.0;
  // and moves with the ball from stage to stage of the horizon
  bool return_follows = false;
  // Beyond (25): the target is drawn no farther from the ball than this, so that one that was
  // pushed away is brought back at the usual speed [m]
  double target_reach = std::numeric_limits<double>::infinity();
  // of several balls: which one is worked on
  double look_ahead = 0.0;  // the balls are looked at where they roll to in this time [s]
  // a ball counts as this much behind, times its distance from the line
  double beside_weight = 0.0;
  double change_margin = 0.0;  // another ball has to be worse off by this much [m]
  double room_ahead = 0.0;     // a ball with another one ahead and nearer than this has no room [m]
};

/// The way to the start pose and the behaviour when the ball is lost.
struct ApproachParameters {
  double speed;         // of the end effector's reference [m/s]
  double safe_height;   // travels at this height above the table [m]
  double start_height;  // above the ball's centre where C3 takes over [m]
  double tolerance;     // start pose reached [m]
  double leash;         // the reference waits for an arm that is farther behind than this [m]
  Eigen::Vector2d reach_min,
      reach_max;       // a ball outside this box of the table is out of reach, in W [m]
  double settle_time;  // C3 starts after this long in the start pose with a ball in view [s]
};

/// How the ball's acceleration is learnt while nobody touches it.
struct DisturbanceParameters {
  double noise;   // of a seen position, standard deviation [m]
  double memory;  // what was seen longer ago than this, of untouched rolling, fades [s]
  double limit;   // the acceleration is never longer than this [m/s²]
  double gap;     // an end effector nearer than this may touch the ball [m]
  double settle;  // nor is the ball looked at for this long after a touch [s]
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
  double estimate_timeout;   // a ball estimate older than this counts as lost [s]
  double deadline_fraction;  // of the period, realtime only
  int N;
  double dt;                         // planning step Δt [s]
  int balls;                         // 1: M_s of one ball; more: balls that stay on the table
  model::BallModelParameters model;  // every ball alike; friction_table: of one ball alone
  double friction_balls;             // μ between balls, of several
  ContactModel contact_model;        // of L_Δt; the step over Δt_c is Stewart and Trinkle's
  // contacts that L_Δt has, of one ball or of several; the step over Δt_c has them all
  std::vector<model::BallContact> contacts;
  std::vector<model::ContactPair> pairs;
  c3::Settings c3;
  PhaseWeights roll, back;  // Phase I and Phase II
  HeuristicParameters heuristic;
  ApproachParameters approach;
  Task task;
  DeltaTcSource delta_t_c_source;
  double speed_limit;     // of the planned end effector [m/s]
  bool predict_ball;      // carry the estimated ball on to the time of the arm's state
  bool separate_overlap;  // move an estimated ball out of the end effector before linearising
  // the table is where the ball lies on it, whatever height the model says: a tilt moves it by
  // millimetres
  bool table_below_ball = false;
  std::optional<DisturbanceParameters> disturbance;  // of one ball alone; none: not learnt
  double tilt;  // of the tool, about the axis (e_y, −e_x, 0) towards its way [rad]
};

}  // namespace c3rt::planner
