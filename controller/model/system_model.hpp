#pragma once
// A system whose LCS is known as a whole about each state: the numerical examples of section VI.
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "controller/lcs/lcs.hpp"

namespace c3rt::model {

/// One entry of x, u or λ: "wall" and "n".
struct Quantity {
  std::string name, unit;
};

/// The order of x, u and λ. The only place that knows it.
struct SystemLayout {
  std::vector<Quantity> x, u, lambda;

  int n_x() const noexcept { return static_cast<int>(x.size()); }
  int n_u() const noexcept { return static_cast<int>(u.size()); }
  int n_lambda() const noexcept { return static_cast<int>(lambda.size()); }
};

class SystemModel {
 public:
  explicit SystemModel(SystemLayout layout) : layout_(std::move(layout)) {}
  virtual ~SystemModel() = default;

  const SystemLayout& layout() const noexcept { return layout_; }

  /// The LCS about a state, to plan with.
  /// @param x (n_x)  @param dt its time step [s]
  virtual lcs::Lcs planning_system(const Eigen::VectorXd& x, double dt) const = 0;
  /// The same for a simulation, with the small regularisation that the published simulations have
  /// where the LCP would be unsolvable at zero normal force.
  virtual lcs::Lcs simulation_system(const Eigen::VectorXd& x, double dt) const {
    return planning_system(x, dt);
  }
  /// Makes an input one that the plant can have: fingers do not pull. @param u (n_u)
  virtual void clip(Eigen::Ref<Eigen::VectorXd> /*u*/) const {}

 private:
  SystemLayout layout_;
};

}  // namespace c3rt::model
