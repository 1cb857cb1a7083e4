#include "controller/lcs/acceptance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace c3rt::lcs {
namespace {

constexpr double kOfTerms = 1e-10;
constexpr double kOfLargestForce = 1e-12;
constexpr double kOfProblem = 1e-4;
constexpr double kExactForces = 1e-12;
constexpr int kSweeps = 16;

}  // namespace

LcpMiss miss(const Eigen::Ref<const Eigen::MatrixXd>& F, const Eigen::Ref<const Eigen::VectorXd>& q,
             const Eigen::Ref<const Eigen::VectorXd>& terms,
             const Eigen::Ref<const Eigen::VectorXd>& R, const Eigen::Ref<const Eigen::VectorXd>& C,
             const Eigen::Ref<const Eigen::VectorXd>& lambda) noexcept {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  LcpMiss worst{0.0, 0.0};
  double largest = 0.0;
  for (Eigen::Index j = 0; j < lambda.size(); ++j) {
    if (!(lambda[j] >= 0.0) || !std::isfinite(lambda[j])) return {kInfinity, kInfinity};
    largest = std::max(largest, lambda[j] / C[j]);
  }
  const double of_problem = kOfProblem * R.cwiseProduct(terms).maxCoeff();
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    double y = q[i], of_terms = terms[i], of_largest = 0.0;
    for (Eigen::Index j = 0; j < q.size(); ++j) {
      const double force = F(i, j) * lambda[j];
      y += force;
      of_terms += std::abs(force);
      of_largest += std::abs(F(i, j)) * C[j];
    }
    if (!std::isfinite(y)) return {kInfinity, kInfinity};
    worst.residual = std::max(worst.residual, std::abs(std::min(lambda[i], y)));
    const double missing = lambda[i] > 0.0 ? std::abs(y) : std::max(-y, 0.0);
    // beside forces too large, y has no digits left
    if (!(std::numeric_limits<double>::epsilon() * of_terms <= of_problem / R[i]) && of_terms > 0.0)
      return {kInfinity, kInfinity};
    if (missing == 0.0) continue;
    const double allowed =
        std::min(kOfTerms * of_terms + kOfLargestForce * of_largest * largest, of_problem / R[i]);
    worst.relative = std::max(worst.relative, missing / allowed);
  }
  return worst;
}

bool is_exact(const Eigen::Ref<const Eigen::MatrixXd>& F,
              const Eigen::Ref<const Eigen::VectorXd>& q,
              const Eigen::Ref<const Eigen::VectorXd>& terms,
              const Eigen::Ref<const Eigen::VectorXd>& lambda, double& residual) noexcept {
  residual = 0.0;
  const double most = kOfProblem / kExactForces * terms.maxCoeff();
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    double y = q[i], of_terms = terms[i];
    for (Eigen::Index j = 0; j < q.size(); ++j) {
      const double force = F(i, j) * lambda[j];
      y += force;
      of_terms += std::abs(force);
    }
    const double missing = lambda[i] > 0.0 ? std::abs(y) : std::max(-y, 0.0);
    if (!(lambda[i] >= 0.0 && missing <= kExactForces * of_terms && of_terms <= most)) return false;
    residual = std::max(residual, std::abs(std::min(lambda[i], y)));
  }
  return true;
}

void equilibrate(const Eigen::Ref<const Eigen::MatrixXd>& F,
                 const Eigen::Ref<const Eigen::VectorXd>& terms, Eigen::Ref<Eigen::VectorXd> R,
                 Eigen::Ref<Eigen::VectorXd> C) noexcept {
  const Eigen::Index n = F.rows();
  R.setOnes();
  C.setOnes();
  double of_terms = 1.0;
  const auto root = [](double largest) {  // 2^k near √largest
    return largest > 0.0 ? std::ldexp(1.0, (std::ilogb(largest) + 1) / 2) : 1.0;
  };
  bool changed = true;
  for (int sweep = 0; sweep < kSweeps && changed; ++sweep) {
    changed = false;
    const auto divide = [&](double& factor, double by) {
      factor /= by;
      changed |= by != 1.0;
    };
    double largest_term = 0.0;
    for (Eigen::Index i = 0; i < n; ++i) {
      double largest = terms[i] * of_terms;
      for (Eigen::Index j = 0; j < n; ++j) largest = std::max(largest, std::abs(F(i, j)) * C[j]);
      divide(R[i], root(R[i] * largest));
      largest_term = std::max(largest_term, R[i] * terms[i] * of_terms);
    }
    for (Eigen::Index j = 0; j < n; ++j) {
      double largest = 0.0;
      for (Eigen::Index i = 0; i < n; ++i) largest = std::max(largest, R[i] * std::abs(F(i, j)));
      divide(C[j], root(largest * C[j]));
    }
    divide(of_terms, root(largest_term));
  }
}

}  // namespace c3rt::lcs
