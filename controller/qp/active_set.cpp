#include "controller/qp/active_set.hpp"

namespace c3rt::qp {

using Eigen::VectorXd;

void ActiveSet::prepare() {
  bound_.assign(rows_.all(), Bound::kNone);
  violated_ = bound_;
}

void ActiveSet::deactivate_all() noexcept {
  for (int i = 0; i < rows_.count(); ++i) {
    bound_[i] = rows_[i].lower == rows_[i].upper ? Bound::kEquality : Bound::kNone;
  }
}

ActiveSet::Corrections ActiveSet::correct(const VectorXd& value, const VectorXd& multiplier,
                                          const VectorXd& inverse_hessian) noexcept {
  const int n = rows_.count();
  double largest = 0.0;
  for (int i = 0; i < n; ++i) {
    if (multiplier[i] == 0.0) continue;
    largest = std::max(largest, std::abs(multiplier[i]) * std::sqrt(inverse_hessian[i]));
  }
  Corrections found;
  for (int i = 0; i < n; ++i) {
    violated_[i] = Bound::kNone;
    if (bound_[i] == Bound::kEquality) continue;
    if (bound_[i] == Bound::kNone) {
      const double outside = rows_.outside(i, value[i]);
      if (std::abs(outside) <= slack(value[i])) continue;
      violated_[i] = outside < 0.0 ? Bound::kLower : Bound::kUpper;
      ++found.violated;
      continue;
    }
    const double outwards = bound_[i] == Bound::kLower ? -multiplier[i] : multiplier[i];
    if (outwards <= 0.0 || outwards <= kTolerance * largest / std::sqrt(inverse_hessian[i]))
      continue;
    bound_[i] = Bound::kNone;
    ++found.wrong_sign;
  }
  for (int i = 0; i < n; ++i) {
    if (violated_[i] == Bound::kNone || is(violated_, rows_.neighbor(i, -1), violated_[i]))
      continue;
    activate_run(i, value);
  }
  return found;
}

/// Whether a row, if there is one (−1: no), is of this kind.
bool ActiveSet::is(const std::vector<Bound>& rows, int row, Bound kind) const noexcept {
  return row >= 0 && row < rows_.count() && rows[row] == kind;
}

/// Where an entry of z violates a bound over several consecutive stages, the bound is active at far
/// fewer in the end. If all of them were activated, only the ends of the run would get the wrong
/// sign, and it would shrink by a stage a correction. So the largest violation alone is activated,
/// and what lies between it and an active neighbour of the run.
void ActiveSet::activate_run(int first, const VectorXd& value) noexcept {
  const Bound side = violated_[first];
  const auto violation = [&](int row) { return std::abs(rows_.outside(row, value[row])); };
  int worst = first, last = first;
  for (int i = first; is(violated_, i, side); i = rows_.neighbor(i, 1)) {
    if (violation(i) > violation(worst)) worst = i;
    last = i;
  }
  if (!is(bound_, rows_.neighbor(first, -1), side)) first = worst;
  if (!is(bound_, rows_.neighbor(last, 1), side)) last = worst;
  for (int i = first; i != last; i = rows_.neighbor(i, 1)) bound_[i] = side;
  bound_[last] = side;
}

}  // namespace c3rt::qp
