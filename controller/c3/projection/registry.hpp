#pragma once
// The projections by name: a new one is a file in this folder and its line in the table below.
#include <array>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "controller/qp/problem.hpp"

namespace c3rt::c3 {

class Consensus;
struct Costs;
class Projection;
struct ProjectionReport;
struct Settings;

/// The table: PROJECTION(Name, name) for each, which name.cpp in this folder implements.
#define C3RT_PROJECTIONS(PROJECTION)                                                         \
  PROJECTION(Miqp, miqp)     /* exact, by branch and bound                 [C3, eq. (23)] */ \
  PROJECTION(Lcp, lcp)       /* λ from the LCP at the x and u of the QP    [C3, V.B.3b] */  \
  PROJECTION(Admm, admm)     /* QCQP by a nested ADMM with bisection       [C3, V.B.3c] */   \
  PROJECTION(Convex, convex) /* one convex QP that trades complementarity against distance   \
                                                                           [C3, eq. (24)] */ \
  PROJECTION(Plus, plus)     /* C3+: gap variables, pair by pair           [C3+, III] */

/// kMiqp, …
enum class ProjectionKind {
#define C3RT_PROJECTION(Name, name) k##Name,
  C3RT_PROJECTIONS(C3RT_PROJECTION)
#undef C3RT_PROJECTION
};

/// A weight that one projection alone has: its place in Costs, and what files may say of it.
struct ProjectionWeight {
  /// (n_x × n_x), (n_u × n_u), (n_lambda) of λ, of the gaps η and of contacts, one number
  enum class Shape { kOfStates, kOfInputs, kOfForces, kOfGaps, kOfContacts, kNumber };

  const char* key;           // in scenarios, in the section that has the projection's key
  const char* problem_name;  // in files of `c3rt solve`
  Shape shape;
  /// The one that the shape has; the others are null.
  Eigen::MatrixXd& (*matrix)(Costs&) = nullptr;
  Eigen::VectorXd& (*vector)(Costs&) = nullptr;
  double& (*number)(Costs&) = nullptr;
  double minimum = 0.0;  // of each entry
  double maximum = std::numeric_limits<double>::infinity();
  bool of_consensus = false;  // a part of what G is without this projection
  bool has_default = false;   // of Costs, where a file of `c3rt solve` leaves it out

  /// The same value for all entries, of a matrix for those on the diagonal.
  void fill(Costs& costs, const qp::Sizes& sizes, double value) const;
};

/// What the solver and the loaders know of a projection.
struct ProjectionType {
  ProjectionKind kind;
  const char* key;           // in scenarios
  const char* problem_name;  // in files of `c3rt solve`
  bool needs_G, needs_U;     // of Costs
  std::unique_ptr<Projection> (*make)(const qp::Sizes& sizes, const Settings& settings);
  /// Its copy, and the consensus term of the QP.
  std::unique_ptr<Consensus> (*make_consensus)(const qp::Sizes& sizes);
  /// Of the weights that it alone has, and of its settings; throw std::invalid_argument naming the
  /// field and what was expected. Null: there are none.
  void (*check_weights)(const Costs& costs, const qp::Sizes& sizes) = nullptr;
  void (*check_settings)(const Settings& settings) = nullptr;
  std::vector<ProjectionWeight> weights = {};  // that it alone has
  /// Why it has no point, for a person, where it knows more of that than `report` says; "" where it
  /// does not. Null: it never does.
  std::string (*why_no_point)(const ProjectionReport& report, const Settings& settings,
                              const Costs& costs, const lcs::Lcs& lcs) = nullptr;
  bool has_nodes = false;  // Settings.max_nodes ends its search
};

// miqp_projection(), …
#define C3RT_PROJECTION(Name, name) const ProjectionType& name##_projection();
C3RT_PROJECTIONS(C3RT_PROJECTION)
#undef C3RT_PROJECTION

inline constexpr std::array kProjectionTypes{
#define C3RT_PROJECTION(Name, name) name##_projection,
    C3RT_PROJECTIONS(C3RT_PROJECTION)
#undef C3RT_PROJECTION
};

const ProjectionType& projection_type(ProjectionKind kind) noexcept;

/// @throws std::invalid_argument as the projection's checks
std::unique_ptr<Projection> make_projection(const qp::Sizes& sizes, const Settings& settings);

}  // namespace c3rt::c3
