#include "controller/impedance/knots.hpp"

namespace c3rt::impedance {

namespace {

const Knot& at(const Knots& knots, int i) noexcept { return knots[static_cast<std::size_t>(i)]; }

Goal goal(const Knot& knot) noexcept {
  return {knot.p_WE, knot.v_WE, Eigen::Quaterniond(knot.q_WE).normalized(), knot.force_E};
}

double seconds_between(std::int64_t from_ns, std::int64_t to_ns) noexcept {
  return static_cast<double>(to_ns - from_ns) * 1e-9;
}

Goal between(const Knot& a, const Knot& b, std::int64_t now_ns) noexcept {
  const double h = seconds_between(a.time_ns, b.time_ns);
  const double s = seconds_between(a.time_ns, now_ns) / h;
  const double r = 1.0 - s;
  Goal goal;
  goal.p_WE = (1.0 + 2.0 * s) * r * r * a.p_WE + s * s * (3.0 - 2.0 * s) * b.p_WE +
              h * s * r * (r * a.v_WE - s * b.v_WE);
  goal.v_WE = (6.0 * s * r / h) * (b.p_WE - a.p_WE) + r * (1.0 - 3.0 * s) * a.v_WE +
              s * (3.0 * s - 2.0) * b.v_WE;
  const Eigen::Quaterniond from = Eigen::Quaterniond(a.q_WE).normalized();
  const Eigen::Quaterniond to = Eigen::Quaterniond(b.q_WE).normalized();
  goal.q_WE = from.slerp(s, to).normalized();
  goal.force_E = r * a.force_E + s * b.force_E;
  return goal;
}

}  // namespace

Goal interpolate(const Knots& knots, int count, std::int64_t now_ns) noexcept {
  if (count == 1 || now_ns <= at(knots, 0).time_ns) return goal(at(knots, 0));
  for (int i = 1; i < count; ++i) {
    if (now_ns < at(knots, i).time_ns) return between(at(knots, i - 1), at(knots, i), now_ns);
  }
  Goal last = goal(at(knots, count - 1));
  last.v_WE.setZero();
  return last;
}

bool are_ordered(const Knots& knots, int count) noexcept {
  if (count < 1 || count > kMaxKnots) return false;
  for (int i = 1; i < count; ++i) {
    if (at(knots, i).time_ns <= at(knots, i - 1).time_ns) return false;
  }
  return true;
}

}  // namespace c3rt::impedance
