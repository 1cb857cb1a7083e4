#include "controller/lcs/lcs.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

#include "controller/lcs/require.hpp"

namespace c3rt::lcs {
Sizes sizes(const Lcs& lcs) {
  return {static_cast<int>(lcs.A.cols()), static_cast<int>(lcs.F.cols()),
          static_cast<int>(lcs.B.cols())};
}

void check(const Lcs& lcs) {
  const auto [n_x, n_lambda, n_u] = sizes(lcs);
  require("Lcs.A", lcs.A, n_x, n_x);
  require("Lcs.B", lcs.B, n_x, n_u);
  require("Lcs.D", lcs.D, n_x, n_lambda);
  require("Lcs.d", lcs.d, n_x, 1);
  require("Lcs.E", lcs.E, n_lambda, n_x);
  require("Lcs.F", lcs.F, n_lambda, n_lambda);
  require("Lcs.H", lcs.H, n_lambda, n_u);
  require("Lcs.c", lcs.c, n_lambda, 1);
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
