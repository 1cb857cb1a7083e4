#include "cli/report/tracking.hpp"

#include <algorithm>

#include <catch2/catch.hpp>

#include "cli/report/metrics.hpp"
#include "controller/task/line.hpp"

namespace {

using namespace c3rt::cli;

constexpr std::int64_t kMs = 1'000'000;

/// 3 s of commands that track from 0.5 s on and are as many mm away as `millimetres` says.
template <typename Millimetres>
Series commands(const Millimetres& millimetres) {
  Series series;
  for (int i = 1; i <= 3000; ++i) {
    const std::int64_t t = i * kMs;
    StateRow state{};
    state.time_ns = t;
    state.p_WE = {0.001 * i, 0.0, 0.0};
    series.state.push_back(state);
    CommandRow command{};
    command.time_ns = t + kMs / 2;
    command.state_ns = t;
    command.tracking = i > 500;
    command.p_WE_desired = state.p_WE + Eigen::Vector3d(0.0, 0.0, 1e-3 * millimetres(i));
    series.command.push_back(command);
  }
  return series;
}

double largest(const TrackingError& errors) {
  return *std::max_element(errors.error.begin(), errors.error.end());
}

}  // namespace

TEST_CASE(
    "tracking errors join a command with the state that it answers and skip the first second") {
  Series series = commands([](int i) { return i < 1501 ? 10.0 : 2.0; });
  series.command[2000].state_ns += 1;  // its state was lost on the way: left out, not an error
  const TrackingErrors tracking = tracking_errors(series);
  REQUIRE(tracking.task.error.size() == 1499);
  REQUIRE(largest(tracking.task) == Approx(0.002));
  // no plan was recorded: what cannot be shown to be an approach is judged
  REQUIRE(tracking.approach.error.empty());
}

TEST_CASE("the way to a ball, also from one to the next, is left out of the tracking error") {
  // 8 mm on the first way, 1 mm at work, 5 mm between two objects, 2 mm at work again
  Series series = commands([](int i) {
    return i <= 1800 ? 8.0 : i <= 2200 ? 1.0 : i <= 2600 ? 5.0 : 2.0;
  });
  const auto plan = [](std::int64_t time_ns, bool rolling) {
    PlanRow row{};
    row.time_ns = time_ns;
    row.rolling = rolling;
    return row;
  };
  series.plan = {plan(10 * kMs, false), plan(1790 * kMs, true), plan(2190 * kMs, false),
                 plan(2590 * kMs, true)};
  for (int i = 1; i <= 3000; ++i) {  // each plan takes effect 10 ms after its time
    series.command[static_cast<std::size_t>(i - 1)].plan_ns = i <= 1800   ? 10 * kMs
                                                              : i <= 2200 ? 1790 * kMs
                                                              : i <= 2600 ? 2190 * kMs
                                                                          : 2590 * kMs;
  }
  const TrackingErrors tracking = tracking_errors(series);
  REQUIRE(tracking.task.error.size() == 800);
  REQUIRE(largest(tracking.task) == Approx(0.002));
  REQUIRE(tracking.approach.error.size() == 700);  // 0.3 s after the first second, then 0.4 s
  REQUIRE(largest(tracking.approach) == Approx(0.008));

  const c3rt::task::Line line{};
  const Figures figures = evaluate(series, line, {{"tracking_error_max_m", {}, 0.003}});
  REQUIRE(figures.tracking_error.max == Approx(0.002));
  REQUIRE(figures.approach_error.max == Approx(0.008));
  REQUIRE(figures.criteria.at(0).met);
}
