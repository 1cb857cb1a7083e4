#include "controller/c3/projection/quadric.hpp"

#include <algorithm>
#include <cmath>

namespace c3rt::c3 {
namespace {

constexpr int kSteps = 200;
constexpr double kRoundingOfConstraint = 1e-15;  // of the largest term of the constraint
constexpr double kBeforeEnd = 1e-10;  // how near ν comes to the end of its interval, relatively

struct Value {
  double q, slope, magnitude;  // magnitude: of the terms that q is the sum of
};

/// The constraint as a function of ν. With `sign` −1 constraint and ν are mirrored.
Value constraint(double q_a, const Eigen::VectorXd& b, const Eigen::VectorXd& curvature,
                 double sign, double nu) noexcept {
  Value value{sign * q_a, 0.0, std::abs(q_a)};
  for (Eigen::Index i = 0; i < b.size(); ++i) {
    const double inverse = 1.0 / (1.0 + sign * nu * curvature[i]);
    const double term = 0.25 * nu * b[i] * b[i] * (inverse + inverse * inverse);
    value.q -= term;
    value.slope -= 0.5 * b[i] * b[i] * inverse * inverse * inverse;
    value.magnitude = std::max(value.magnitude, term);
  }
  return value;
}

}  // namespace

double nearest_on_quadric(double q_0, const Eigen::VectorXd& g, const Eigen::VectorXd& curvature,
                          const Eigen::VectorXd& a, Eigen::VectorXd& h) noexcept {
  h = g + 2.0 * curvature.cwiseProduct(a);  // b, until the end
  const Eigen::VectorXd& b = h;
  const double q_a = q_0 + 0.5 * a.dot(g + b);
  if (q_a == 0.0) {
    h = a;
    return 0.0;
  }
  // ν > 0 lowers a constraint above zero; the other case is its mirror image
  const double sign = q_a > 0.0 ? 1.0 : -1.0;
  int extreme = 0;
  for (int i = 1; i < static_cast<int>(b.size()); ++i) {
    if (sign * curvature[i] < sign * curvature[extreme]) extreme = i;
  }
  const double bend = sign * curvature[extreme];
  double low = 0.0, high = 0.0;
  bool reached = true;
  if (bend < 0.0) {
    high = (1.0 - kBeforeEnd) / -bend;
    reached = constraint(q_a, b, curvature, sign, high).q <= 0.0;
  } else {
    // the root, were it not bent; bent upwards it is farther away, if there is one
    high = std::min(2.0 * std::abs(q_a) / std::max(b.squaredNorm(), 1e-100), 1e100);
    for (int i = 0; i < kSteps; ++i, low = high, high *= 2.0) {
      reached = constraint(q_a, b, curvature, sign, high).q <= 0.0;
      if (reached) break;
    }
  }
  double nu = reached ? low : high;
  for (int i = 0; reached && i < kSteps; ++i) {
    const Value value = constraint(q_a, b, curvature, sign, nu);
    (value.q > 0.0 ? low : high) = nu;
    if (std::abs(value.q) <= kRoundingOfConstraint * value.magnitude) break;
    // Newton's step where it stays inside, else the middle
    const double newton = nu - value.q / value.slope;
    const double next = newton > low && newton < high ? newton : 0.5 * (low + high);
    if (next == nu) break;
    nu = next;
  }
  const double rest = constraint(q_a, b, curvature, sign, nu).q;
  const double b_extreme = sign * b[extreme];
  for (Eigen::Index i = 0; i < h.size(); ++i) {
    h[i] = a[i] - sign * 0.5 * nu * b[i] / (1.0 + sign * nu * curvature[i]);
  }
  if (reached || bend >= 0.0) return sign * rest;
  // rest + s e + bend e² = 0 for the further step e along the extreme direction, s its slope there
  const double slope = b_extreme + 2.0 * bend * (h[extreme] - a[extreme]);
  const double root = std::sqrt(slope * slope - 4.0 * bend * rest);
  h[extreme] += slope > 0.0 ? -2.0 * rest / (slope + root) : 2.0 * rest / (root - slope);
  return 0.0;
}

}  // namespace c3rt::c3
