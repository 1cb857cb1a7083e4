// Synthetic runs whose excursions are known.
#include "cli/report/excursions.hpp"

#include <cmath>
#include <functional>

#include <catch2/catch.hpp>

#include "cli/report/metrics.hpp"
#include "controller/task/circle.hpp"

namespace {

using namespace c3rt::cli;

constexpr std::int64_t kMs = 1'000'000;
const c3rt::task::Circle kCircle{{0.55, 0.0}, 0.1, 0.35};

/// An object that goes round in 20 s, off the circle by what `off` says; 10 ms per row, for 40 s.
Series round_trip(const std::function<double(double)>& off) {
  Series series;
  PlanRow plan{};
  plan.rolling = true;
  series.plan.push_back(plan);
  for (int i = 0; i <= 4000; ++i) {
    const double time = 0.01 * i, angle = 2.0 * M_PI * time / 20.0;
    SceneRow row{};
    row.time_ns = i * 10 * kMs;
    row.object_count = 1;
    const double radius = kCircle.radius + off(time);
    row.p_WB[0] = {0.55 + radius * std::sin(angle), radius * std::cos(angle), 0.0315};
    series.scene.push_back(row);
  }
  return series;
}

double between(double time, double from, double until, double off) {
  return time >= from && time < until ? off : 0.0;
}

}  // namespace

TEST_CASE("excursions: their number, the longest, the farthest, and that the ball came back") {
  const Series series = round_trip(
      [](double t) { return between(t, 10.0, 12.5, 0.03) - between(t, 20.0, 21.0, 0.05); });
  const ExcursionFigures figures = excursion_figures(series, kCircle, 5.0, {});
  REQUIRE(figures.excursions.size() == 2);
  CHECK(figures.excursions[0].start == Approx(10.0).margin(0.011));
  CHECK(figures.excursions[0].duration == Approx(2.5).margin(0.011));
  CHECK(figures.excursions[0].returned);
  CHECK(figures.excursions[1].largest == Approx(0.05).margin(1e-9));
  CHECK(figures.longest == Approx(2.5).margin(0.011));
  CHECK(figures.largest == Approx(0.05).margin(1e-9));
  CHECK(figures.ended_in_band == true);
}

TEST_CASE("excursions: one that lasts to the end, or to its last second, is not a return") {
  const auto ended = [](double until) {
    const Series series = round_trip([&](double t) { return between(t, 38.0, until, 0.03); });
    return excursion_figures(series, kCircle, 5.0, {});
  };
  CHECK(ended(41.0).ended_in_band == false);
  CHECK_FALSE(ended(41.0).excursions.at(0).returned);
  CHECK(ended(41.0).longest == Approx(2.0).margin(0.011));
  CHECK(ended(39.5).ended_in_band == false);
  CHECK(ended(38.5).ended_in_band == true);
}

TEST_CASE("excursions: a push is answered for until the next one") {
  const Series series = round_trip([](double t) { return between(t, 10.5, 12.0, 0.04); });
  const std::vector<c3rt::plant::Push> pushes = {{1.0, 0, {0.01, 0, 0}},
                                                 {10.0, 0, {0.01, 0, 0}},
                                                 {11.0, 0, {0.01, 0, 0}},
                                                 {50.0, 0, {0, 0, 0}}};
  const ExcursionFigures figures = excursion_figures(series, kCircle, 5.0, pushes);
  // the first is before the object is judged, the last after the end
  REQUIRE(figures.pushes.size() == 2);
  CHECK_FALSE(figures.pushes[0].returned);
  CHECK(figures.pushes[0].out_of_band == Approx(0.5).margin(0.011));
  CHECK(figures.pushes[1].returned);
  CHECK(figures.pushes[1].out_of_band == Approx(1.0).margin(0.011));
  CHECK(figures.pushes[1].largest == Approx(0.04).margin(1e-9));
}

TEST_CASE("excursions: a ball that never set out meets no criterion about them") {
  const Series series = round_trip([](double) { return 0.0; });
  const ExcursionFigures none = excursion_figures(series, kCircle, kNone, {});
  CHECK(std::isnan(none.longest));
  CHECK_FALSE(none.ended_in_band.has_value());
  Series parked = series;
  for (SceneRow& row : parked.scene) row.p_WB[0] = {0.55, 0.1, 0.0315};
  const Figures figures =
      evaluate(parked, kCircle,
               {{"longest_excursion_s", std::nullopt, 5.0}, {"ended_in_band", 1.0, std::nullopt}});
  for (const CriterionResult& criterion : figures.criteria) CHECK_FALSE(criterion.met);
}

TEST_CASE("excursions: criteria look at the longest, the farthest and the end") {
  const Series series = round_trip([](double t) { return between(t, 10.0, 12.5, 0.03); });
  const Figures figures = evaluate(series, kCircle,
                                   {{"longest_excursion_s", std::nullopt, 3.0},
                                    {"largest_excursion_m", std::nullopt, 0.025},
                                    {"ended_in_band", 1.0, std::nullopt}});
  REQUIRE(figures.criteria.size() == 3);
  CHECK(figures.criteria[0].met);
  CHECK_FALSE(figures.criteria[1].met);
  CHECK(figures.criteria[2].met);
}
