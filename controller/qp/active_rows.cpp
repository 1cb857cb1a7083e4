#include "controller/qp/active_rows.hpp"

namespace c3rt::qp {
namespace {

using Eigen::VectorXd;

constexpr double kWorst = 0.85;         // of a run's largest violation: held
constexpr double kWorstAtAnEnd = 0.95;  // the same where it is the first or last of the run

}  // namespace

void ActiveRows::prepare() {
  held_.assign(rows_.all(), Held::kNo);
  before_ = violated_ = held_;
}

void ActiveRows::release() noexcept {
  for (int i = 0; i < rows_.count(); ++i) {
    held_[i] = rows_[i].lower == rows_[i].upper ? Held::kEquality : Held::kNo;
  }
}

/// Lets go of rows that pull the wrong way and holds rows that are violated. Where an entry of z is
/// violated over a run of stages, the bound holds at far fewer in the end: holding all of them,
/// only the ends of the run would pull the wrong way, and it would shrink by a stage a correction.
/// So only the worst of each run are held, from which the set grows outwards in a few corrections.
ActiveRows::Corrections ActiveRows::correct(const VectorXd& value, const VectorXd& multiplier,
                                            const VectorXd& compliance) noexcept {
  before_ = held_;
  const int n = rows_.count();
  double pull = 0.0;
  for (int i = 0; i < n; ++i) {
    if (multiplier[i] == 0.0) continue;
    pull = std::max(pull, std::abs(multiplier[i]) * std::sqrt(compliance[i]));
  }
  Corrections made;
  for (int i = 0; i < n; ++i) {
    violated_[i] = Held::kNo;
    if (held_[i] == Held::kEquality) continue;
    if (held_[i] == Held::kNo) {
      const QpRows::Row& row = rows_[i];
      const double at = value[i];
      if (at < row.lower - slack(at)) violated_[i] = Held::kLower;
      if (at > row.upper + slack(at)) violated_[i] = Held::kUpper;
      continue;
    }
    const double outwards = held_[i] == Held::kLower ? -multiplier[i] : multiplier[i];
    if (outwards <= 0.0 || outwards <= kTolerance * pull / std::sqrt(compliance[i])) continue;
    held_[i] = Held::kNo;
    ++made.released;
  }
  for (int i = 0; i < n; ++i) {
    const int earlier = rows_.beside(i, -1);
    if (violated_[i] == Held::kNo || is(violated_, earlier, violated_[i])) continue;
    hold_run(i, value, made);
  }
  return made;
}

/// Whether a row, if there is one (−1: no), is of this kind.
bool ActiveRows::is(const std::vector<Held>& rows, int row, Held kind) const noexcept {
  return row >= 0 && row < rows_.count() && rows[row] == kind;
}

/// Holds rows of the run of violated ones that begins here: from held rows beside it on up to the
/// top of the parabola through its worst and the two beside that one, where the bound was found to
/// end. Where nothing beside is held, or too little for a guess so far away, the worst alone.
void ActiveRows::hold_run(int first, const VectorXd& value, Corrections& made) noexcept {
  const Held side = violated_[first];
  const auto outside = [&](int row) {
    return side == Held::kLower ? rows_[row].lower - value[row] : value[row] - rows_[row].upper;
  };
  int worst = first, last = first, end = first;
  for (; is(violated_, end, side); end = rows_.beside(end, 1)) {
    if (outside(end) > outside(worst)) worst = end;
    last = end;
  }
  bool extended = false;
  const auto extend = [&](int from, int step) {
    const int held = rows_.beside(from, -step), behind = held < 0 ? -1 : rows_.beside(held, -step);
    if (!is(held_, held, side)) return;
    int length = 0, distance = 1;
    for (int i = held; is(before_, i, side); i = rows_.beside(i, -step)) ++length;
    for (int i = from; i != worst; i = rows_.beside(i, step)) ++distance;
    // the worst is nearer to the top than the next one inwards, or the top is between the two
    const int before = rows_.beside(worst, -step), after = rows_.beside(worst, step);
    if (distance > 1 && after >= 0 && outside(before) > outside(after)) --distance;
    if (distance > length) return;
    for (int i = from; distance > 0; i = rows_.beside(i, step), --distance) {
      made.taken += held_[i] == side ? 0 : 1;
      held_[i] = side;
    }
    // what pulls the wrong way behind the end of a run does so because the run is too short
    if (is(before_, behind, side) && !is(held_, behind, side)) {
      held_[behind] = side;
      --made.released;
    }
    extended = true;
  };
  extend(first, 1);
  extend(last, -1);
  if (extended) return;
  const double share = worst == first || worst == last ? kWorstAtAnEnd : kWorst;
  for (int i = first; i != end; i = rows_.beside(i, 1)) {
    if (outside(i) < share * outside(worst)) continue;
    held_[i] = side;
    ++made.taken;
  }
}

}  // namespace c3rt::qp
