#pragma once
// The reduced model of several balls on a table [C3, section VII-B]: a point-mass end effector with
// a spherical tip, and balls that never leave the table and roll on it without slipping.
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "controller/model/contact_system.hpp"
#include "controller/model/registry.hpp"

namespace c3rt::model {

struct BallsModelParameters {
  struct Ball {
    double mass;    // [kg]; a solid sphere
    double radius;  // [m]
  };
  double end_effector_mass;      // [kg]; a planning parameter, not the arm's
  double end_effector_radius;    // [m]
  double table_height;           // of the table's surface in W [m]
  double friction_end_effector;  // μ between end effector and balls
  double friction_balls;         // μ between balls
  std::vector<Ball> balls;
};

/// x = [p_WE (3); xy of each ball; v_WE (3); v_xy of each ball], u = force on the end effector in W
/// [N]. 2 balls: n_x = 14, 3 balls: n_x = 18. The only place that knows the order.
struct BallsLayout {
  int balls;
  static constexpr int n_u = 3, p_WE = 0;
  constexpr int n_v() const { return 3 + 2 * balls; }
  constexpr int n_x() const { return 2 * n_v(); }
  constexpr int p_WB(int ball) const { return 3 + 2 * ball; }
  constexpr int v_WE() const { return n_v(); }
  constexpr int v_WB(int ball) const { return n_v() + 3 + 2 * ball; }
};

/// The end effector with each ball in turn, then each ball with each later one: 3 pairs of 2 balls,
/// 6 pairs of 3 balls.
std::vector<ContactPair> all_contact_pairs(int balls);

/// The model at the state x. Gravity acts on the end effector; each contact has 4 edges +t −t +s
/// −s, so n_lambda is 6 for each pair with stewart_trinkle, 4 with anitescu.
///
/// A ball that rolls turns with ω = ẑ × v / r, so it moves like a mass of m + I / r² = 7/5 m, and
/// its surface passes the point n away from its centre (in radii) with (1 + n_z) v − ẑ (n · v). It
/// does not turn about ẑ.
///
/// @param pairs the contacts, in the order of the λ
/// @throws std::invalid_argument if x has not the size of the layout, or a pair names a body that
///         is not there or one body twice
/// Precondition: the centres of two bodies of a pair differ.
ContactSystem balls_contact_system(const BallsModelParameters& parameters,
                                   const std::vector<ContactPair>& pairs, const Eigen::VectorXd& x);

/// Balls that stay on the table and roll: 14, 18 or 22 states of 2, 3 or 4 [C3, VII-B].
std::unique_ptr<PlanningModel> make_rolling_balls(const BallsModelParameters& parameters);
ModelKind rolling_balls_kind();

}  // namespace c3rt::model
