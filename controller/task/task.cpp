#include "controller/task/task.hpp"

namespace c3rt::task {
namespace {
// what is told as the limit is within it, whatever the rounding
constexpr double kRounding = 1e-9;
}  // namespace

bool Limits::holds(const Eigen::Vector2d& at) const {
  // written so that NaN fails
  return (at.array() >= reach.min().array() - kRounding).all() &&
         (at.array() <= reach.max().array() + kRounding).all();
}

std::string Limits::words(double inside) const {
  return task::words("x in [%g, %g] and y in [%g, %g] m", reach.min().x() + inside,
                     reach.max().x() - inside, reach.min().y() + inside, reach.max().y() - inside);
}

}  // namespace c3rt::task
