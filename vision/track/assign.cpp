#include "vision/track/assign.hpp"

#include <limits>

namespace c3rt::vision {
namespace {

class Search {
 public:
  Search(const Eigen::MatrixXd& cost, double unassigned)
      : cost_(cost),
        unassigned_(unassigned),
        taken_(static_cast<std::size_t>(cost.cols()), false),
        current_(static_cast<std::size_t>(cost.rows()), -1),
        best_(current_) {
    extend(0, 0.0);
  }
  const std::vector<int>& best() const { return best_; }

 private:
  void extend(Eigen::Index row, double sum) {
    if (sum >= best_sum_) return;
    if (row == cost_.rows()) {
      best_sum_ = sum;
      best_ = current_;
      return;
    }
    int& column = current_[static_cast<std::size_t>(row)];
    for (Eigen::Index j = 0; j < cost_.cols(); ++j) {
      if (taken_[static_cast<std::size_t>(j)] || !(cost_(row, j) < unassigned_)) continue;
      taken_[static_cast<std::size_t>(j)] = true;
      column = static_cast<int>(j);
      extend(row + 1, sum + cost_(row, j));
      taken_[static_cast<std::size_t>(j)] = false;
    }
    column = -1;
    extend(row + 1, sum + unassigned_);
  }

  const Eigen::MatrixXd& cost_;
  double unassigned_;
  double best_sum_ = std::numeric_limits<double>::infinity();
  std::vector<bool> taken_;
  std::vector<int> current_, best_;
};

}  // namespace

std::vector<int> assign(const Eigen::MatrixXd& cost, double unassigned) {
  return Search(cost, unassigned).best();
}

}  // namespace c3rt::vision
