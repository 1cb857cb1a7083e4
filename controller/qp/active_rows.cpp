#include "controller/qp/active_rows.hpp"

namespace c3rt::qp {

using Eigen::VectorXd;

void ActiveRows::prepare() {
  held_.assign(rows_.all(), Held::kNo);
  violated_ = held_;
}

void ActiveRows::release() noexcept {
  for (int i = 0; i < rows_.count(); ++i) {
    held_[i] = rows_[i].lower == rows_[i].upper ? Held::kEquality : Held::kNo;
  }
}

ActiveRows::Corrections ActiveRows::correct(const VectorXd& value, const VectorXd& multiplier,
                                            const VectorXd& compliance) noexcept {
  const int n = rows_.count();
  double largest = 0.0;
  for (int i = 0; i < n; ++i) {
    if (multiplier[i] == 0.0) continue;
    largest = std::max(largest, std::abs(multiplier[i]) * std::sqrt(compliance[i]));
  }
  Corrections found;
  for (int i = 0; i < n; ++i) {
    violated_[i] = Held::kNo;
    if (held_[i] == Held::kEquality) continue;
    if (held_[i] == Held::kNo) {
      const double outside = rows_.outside(i, value[i]);
      if (std::abs(outside) <= slack(value[i])) continue;
      violated_[i] = outside < 0.0 ? Held::kLower : Held::kUpper;
      ++found.violated;
      continue;
    }
    const double outwards = held_[i] == Held::kLower ? -multiplier[i] : multiplier[i];
    if (outwards <= 0.0 || outwards <= kTolerance * largest / std::sqrt(compliance[i])) continue;
    held_[i] = Held::kNo;
    ++found.wrong_sign;
  }
  for (int i = 0; i < n; ++i) {
    if (violated_[i] == Held::kNo || is(violated_, rows_.beside(i, -1), violated_[i])) continue;
    activate_run(i, value);
  }
  return found;
}

/// Whether a row, if there is one (−1: no), is of this kind.
bool ActiveRows::is(const std::vector<Held>& rows, int row, Held kind) const noexcept {
  return row >= 0 && row < rows_.count() && rows[row] == kind;
}

/// Where an entry of z violates a bound over several consecutive stages, the bound is active at far
/// fewer in the end. If all of them were activated, only the ends of the run would get the wrong
/// sign, and it would shrink by a stage a correction. So the largest violation alone is activated,
/// and what lies between it and an active neighbour of the run.
void ActiveRows::activate_run(int first, const VectorXd& value) noexcept {
  const Held side = violated_[first];
  const auto violation = [&](int row) { return std::abs(rows_.outside(row, value[row])); };
  int worst = first, last = first;
  for (int i = first; is(violated_, i, side); i = rows_.beside(i, 1)) {
    if (violation(i) > violation(worst)) worst = i;
    last = i;
  }
  if (!is(held_, rows_.beside(first, -1), side)) first = worst;
  if (!is(held_, rows_.beside(last, 1), side)) last = worst;
  for (int i = first; i != last; i = rows_.beside(i, 1)) held_[i] = side;
  held_[last] = side;
}

}  // namespace c3rt::qp
