#include <algorithm>
#include <cstring>

#include "controller/c3/polish.hpp"

namespace c3rt::c3 {
namespace {

using Eigen::MatrixXd;

constexpr int kMaxMoves = 50;  // of a call

}  // namespace

void Polish::explore(const Deadline& deadline) noexcept {
  if (report_.status != PolishStatus::kBest) return;
  if (report_.qps + kFewestQps > max_qps_) return;
  find_contacts();
  random_ = 0;
  for (int i = 0; i < sizes_.n_x; ++i) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &x0_[i], sizeof bits);
    random_ = (random_ ^ bits) * 0x9e3779b97f4a7c15U;
    random_ ^= random_ >> 32U;
  }
  for (int moves = 0; moves < kMaxMoves && report_.qps + kFewestQps <= max_qps_; ++moves) {
    if (!draw_move()) continue;
    limit_ = std::min(max_qps_, report_.qps + kMoveQps);
    load(plan_, false);
    hold_kept();
    descend(plan_, Effort::kQuick, deadline);
    if (report_.status == PolishStatus::kDeadline) break;
    report_.status = PolishStatus::kBest;  // the limit was the move's
  }
}

/// Pairs of one contact: friction's cone makes F asymmetric between them, which the masses that
/// couple contacts do not.
void Polish::find_contacts() noexcept {
  const MatrixXd& F = lcs_[0].F;
  const int n = sizes_.n_lambda;
  for (int i = 0; i < n; ++i) contact_[i] = i;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < i; ++j) {
      if ((F(i, j) == 0.0 && F(j, i) == 0.0) || F(i, j) * F(j, i) > 0.0) continue;
      const int from = std::max(contact_[i], contact_[j]), to = std::min(contact_[i], contact_[j]);
      for (int l = 0; l < n; ++l) {
        if (contact_[l] == from) contact_[l] = to;
      }
    }
  }
}

int Polish::draw(int below) noexcept {
  random_ = random_ * 6364136223846793005U + 1442695040888963407U;  // [Knuth]
  return static_cast<int>((random_ >> 33U) % static_cast<std::uint64_t>(below));
}

/// The best plan with other modes: those of a contact are drawn for a range of stages. Half of the
/// ranges begin at stage 0, whose input is the next to be applied, a quarter at stage 1, …; half go
/// on to the last stage, as where a contact is left for good, the others to one stage more three
/// times out of four. False where the modes are as before.
bool Polish::draw_move() noexcept {
  const int n_lambda = sizes_.n_lambda;
  move_.contact = contact_[draw(n_lambda)];
  move_.first = 0;
  while (move_.first + 1 < sizes_.N && draw(2) == 0) ++move_.first;
  move_.last = move_.first;
  while (move_.last + 1 < sizes_.N && draw(4) != 0) ++move_.last;
  if (draw(2) == 0) move_.last = sizes_.N - 1;
  plan_ = best_;
  bool any = false;
  for (int j = 0; j < n_lambda; ++j) {
    if (contact_[j] != move_.contact) continue;
    const char to = draw(2) == 0 ? 0 : 1;
    for (int k = move_.first; k <= move_.last; ++k) {
      char& force = plan_.force[k * n_lambda + j];
      any |= force != to;
      force = to;
    }
  }
  return any;
}

void Polish::keep_active() noexcept {
  kept_.clear();
  for (const int row : active_)
    kept_.push_back({row, side_[row], weight_[row], multiplier_[row], inverse_hessian_[row]});
}

/// Holds the rows of the best plan that a move does not touch.
void Polish::hold_kept() noexcept {
  const int n_lambda = sizes_.n_lambda;
  for (const Kept& kept : kept_) {
    if (is_pair(kept.row)) {
      const int k = kept.row / n_lambda, j = kept.row % n_lambda;
      if (k >= move_.first && k <= move_.last && contact_[j] == move_.contact) continue;
    }
    side_[kept.row] = kept.side;
    weight_[kept.row] = kept.weight;
    multiplier_[kept.row] = kept.multiplier;
    inverse_hessian_[kept.row] = kept.inverse_hessian;
    active_.push_back(kept.row);
  }
}

}  // namespace c3rt::c3
