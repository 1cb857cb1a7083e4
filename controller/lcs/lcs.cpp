#include "controller/lcs/lcs.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

namespace c3rt::lcs {
namespace {

void require(const char* name, const Eigen::Ref<const Eigen::MatrixXd>& block, Eigen::Index rows,
             Eigen::Index cols) {
  const auto shape = [](Eigen::Index r, Eigen::Index c) {
    return std::to_string(r) + " x " + std::to_string(c);
  };
  if (block.rows() != rows || block.cols() != cols) {
    throw std::invalid_argument("Lcs." + std::string(name) + ": expected " + shape(rows, cols) +
                                ", got " + shape(block.rows(), block.cols()));
  }
  if (!block.allFinite()) {
    throw std::invalid_argument("Lcs." + std::string(name) +
                                ": expected finite numbers, got NaN or infinity");
  }
}

}  // namespace

Sizes sizes(const Lcs& lcs) {
  return {static_cast<int>(lcs.A.cols()), static_cast<int>(lcs.F.cols()),
          static_cast<int>(lcs.B.cols())};
}

void check(const Lcs& lcs) {
  const auto [n_x, n_lambda, n_u] = sizes(lcs);
  require("A", lcs.A, n_x, n_x);
  require("B", lcs.B, n_x, n_u);
  require("D", lcs.D, n_x, n_lambda);
  require("d", lcs.d, n_x, 1);
  require("E", lcs.E, n_lambda, n_x);
  require("F", lcs.F, n_lambda, n_lambda);
  require("H", lcs.H, n_lambda, n_u);
  require("c", lcs.c, n_lambda, 1);
}

std::optional<double> find_force_scale(const Lcs& lcs) noexcept {
  const double scale = lcs.A.squaredNorm() / lcs.D.squaredNorm();
  if (!(std::isfinite(scale) && scale > 0.0)) return std::nullopt;
  return scale;
}

double force_scale(const Lcs& lcs) {
  const std::optional<double> scale = find_force_scale(lcs);
  if (!scale)
    throw std::invalid_argument("Lcs.A, Lcs.D: expected finite matrices that are not zero");
  return *scale;
}

void scale_forces(Lcs& lcs, double s) {
  if (!(std::isfinite(s) && s > 0.0)) {
    throw std::invalid_argument("force scale: expected a positive number, got " +
                                std::to_string(s));
  }
  lcs.D *= s;
  lcs.E /= s;
  lcs.H /= s;
  lcs.c /= s;
}

}  // namespace c3rt::lcs
