// Synthetic runs whose figures are known in closed form.
#include "cli/report/metrics.hpp"

#include <cmath>

#include <catch2/catch.hpp>

#include "controller/task/circle.hpp"
#include "controller/task/line.hpp"
#include "controller/task/path.hpp"

namespace {

using namespace c3rt::cli;

constexpr std::int64_t kMs = 1'000'000;
const c3rt::task::Circle kCircle{{0.55, 0.0}, 0.1, 0.35};

/// An object that goes round a circle of `radius` about `center` at constant speed; 10 ms per row.
Series orbit(const Eigen::Vector2d& center, double radius, double turns_per_s, double duration) {
  Series series;
  series.plan.push_back({0, 0, 0, true, false, false, 0.001});
  for (int i = 0; i <= static_cast<int>(duration * 100.0 + 0.5); ++i) {
    const double angle = 2.0 * M_PI * turns_per_s * i * 0.01;
    SceneRow row{};
    row.time_ns = i * 10 * kMs;
    row.object_count = 1;
    // α = atan2(x − x_c, y − y_c) grows: clockwise seen from above
    row.p_WB[0] = {center.x() + radius * std::sin(angle), center.y() + radius * std::cos(angle),
                   0.0315};
    series.scene.push_back(row);
  }
  return series;
}

CriterionResult criterion(const Series& series, const Limit& limit) {
  const Figures figures = evaluate(series, kCircle, {limit});
  REQUIRE(figures.criteria.size() == 1);
  return figures.criteria.front();
}

}  // namespace

TEST_CASE("a ball on the circle at constant speed has no error and equal loop times") {
  const Figures figures = evaluate(orbit(kCircle.center, 0.1, 0.05, 50.0), kCircle, {});
  REQUIRE(figures.loops_completed == 2);  // 2.5 turns
  REQUIRE(figures.turns == Approx(2.5));
  REQUIRE(figures.loop_times.size() == 2);
  REQUIRE(figures.loop_times[0] == Approx(20.0).margin(1e-6));
  REQUIRE(figures.loop_times[1] == Approx(20.0).margin(1e-6));
  REQUIRE(figures.objects.size() == 1);
  REQUIRE(figures.objects[0].max_error < 1e-12);
  REQUIRE(figures.objects[0].in_band_2cm == Approx(1.0));
}

TEST_CASE("loops count in the task's direction only") {
  c3rt::task::Circle other_way = kCircle;
  other_way.lead = -0.35;
  const Figures figures = evaluate(orbit(kCircle.center, 0.1, 0.05, 50.0), other_way, {});
  REQUIRE(figures.loops_completed == 0);
  REQUIRE(figures.turns == Approx(-2.5));
}

TEST_CASE("going back and forth over the start completes no loop") {
  const auto loops = kCircle.progress();
  for (int i = 0; i < 1000; ++i) {
    const double angle = 0.5 * std::sin(0.1 * i);
    loops->add(0.01 * i,
               {kCircle.center + 0.1 * Eigen::Vector2d(std::sin(angle), std::cos(angle))});
  }
  REQUIRE(loops->completed() == 0);
  REQUIRE(std::abs(loops->amount()) < 0.1);
}

TEST_CASE("an offset circle has the errors of its offset") {
  // centre moved by e = 15 mm: |p − c| = sqrt(r² + e² + 2 r e cos φ), so the largest error is e
  // where cos φ = ±1
  const double e = 0.015;
  const Figures figures = evaluate(orbit({0.55 + e, 0.0}, 0.1, 0.05, 40.0), kCircle, {});
  const ObjectFigures& object = figures.objects.at(0);
  REQUIRE(object.max_error == Approx(e).margin(1e-6));
  REQUIRE(object.in_band_2cm == Approx(1.0));
  double squares = 0.0, inside = 0.0;  // the same integral over the angle, sampled finely
  constexpr int kSamples = 100000;
  for (int i = 0; i < kSamples; ++i) {
    const double phi = 2.0 * M_PI * i / kSamples;
    const double error = std::sqrt(0.01 + e * e + 2.0 * 0.1 * e * std::cos(phi)) - 0.1;
    squares += error * error;
    inside += std::abs(error) <= 0.01 ? 1.0 : 0.0;
  }
  REQUIRE(object.rms_error == Approx(std::sqrt(squares / kSamples)).epsilon(1e-3));
  REQUIRE(object.in_band_1cm == Approx(inside / kSamples).margin(2e-3));
}

TEST_CASE("the time in the band is weighted by time, not by samples") {
  Series series = orbit(kCircle.center, 0.1, 0.0, 0.0);
  series.scene.clear();
  // 1 s inside in one row, then 1 s outside in a hundred rows
  SceneRow row{};
  row.object_count = 1;
  row.p_WB[0] = {0.55, 0.1, 0.0315};
  series.scene.push_back(row);
  row.p_WB[0] = {0.55, 0.15, 0.0315};
  for (int i = 0; i <= 100; ++i) {
    row.time_ns = 1000 * kMs + i * 10 * kMs;
    series.scene.push_back(row);
  }
  REQUIRE(evaluate(series, kCircle, {}).objects.at(0).in_band_2cm == Approx(0.5));
}

TEST_CASE(
    "a parked ball completes no loop and meets no criterion, though it never leaves the band") {
  const Series series = orbit(kCircle.center, 0.1, 0.0, 30.0);
  const Figures figures = evaluate(series, kCircle, {});
  REQUIRE(figures.loops_completed == 0);
  REQUIRE(figures.objects.at(0).in_band_2cm == Approx(1.0));
  REQUIRE_FALSE(criterion(series, {"loops_completed", 1.0, {}}).met);
  REQUIRE_FALSE(criterion(series, {"max_loop_time_s", {}, 25.0}).met);
  REQUIRE_FALSE(criterion(series, {"in_band_2cm", 0.95, {}}).met);
}

TEST_CASE("criteria on the band begin after the first quarter circle") {
  Series series = orbit(kCircle.center, 0.1, 0.05, 40.0);
  for (SceneRow& row :
       series.scene) {  // the first quarter takes 5 s; the first 4 s run outside the band
    if (row.time_ns < 4000 * kMs)
      row.p_WB[0].head<2>() = kCircle.center + 1.4 * (row.p_WB[0].head<2>() - kCircle.center);
  }
  const Figures figures = evaluate(series, kCircle, {});
  REQUIRE(figures.objects.at(0).in_band_2cm == Approx(0.9));  // from the start: 36 s of 40 s
  const CriterionResult band = criterion(series, {"in_band_2cm", 1.0, {}});
  REQUIRE(band.value == Approx(1.0));
  REQUIRE(band.met);
}

TEST_CASE("the task starts with the first plan that rolls, not with the approach") {
  Series series = orbit(kCircle.center, 0.1, 0.05, 40.0);
  series.plan = {{0, 0, 0, false, false, false, 0.0},
                 {10'020 * kMs, 10'000 * kMs, 0, true, false, false, 0.001}};
  const Figures figures = evaluate(series, kCircle, {});
  REQUIRE(figures.task_start == Approx(10.0));
  REQUIRE(figures.turns == Approx(1.5));
  REQUIRE(figures.loops_completed == 1);
}

namespace {
/// A straight path there and back at 0.02 m/s, 0.02 m a way-point, and an object that follows it
/// `late` seconds late; 10 ms per row, the task begins after 3 s.
const c3rt::task::Path kThereAndBack{{{0.5, 0.0}, {0.52, 0.0}, {0.54, 0.0}, {0.52, 0.0}},
                                     1.0,
                                     c3rt::task::Between::kInterpolate,
                                     0.0,
                                     true};
Series follower(double late, double duration) {
  Series series;
  series.plan.push_back({3'020 * kMs, 3'000 * kMs, 0, true, false, false, 0.001});
  for (int i = 0; i <= static_cast<int>(duration * 100.0 + 0.5); ++i) {
    SceneRow row{};
    row.time_ns = i * 10 * kMs;
    row.object_count = 1;
    row.p_WB[0].head<2>() = kThereAndBack.point(0.01 * i - 3.0 - late);
    series.scene.push_back(row);
  }
  return series;
}
}  // namespace

TEST_CASE("a path in time is judged by the distance to the point of the time") {
  // half a second late at 0.02 m/s: 10 mm, but for the half second after each turn at an end, where
  // point and object pass each other: |10 mm - 40 mm/s t|, of mean square 100/3 mm²
  const Figures figures = evaluate(follower(0.5, 43.0), kThereAndBack, {});
  CHECK(figures.task_start == Approx(3.0));
  CHECK(figures.turns == Approx(10.0));
  CHECK(figures.loops_completed == 10);
  CHECK(figures.unit == "rounds");
  REQUIRE(figures.readings.size() == 2);
  CHECK(figures.judged.max_error == Approx(0.01).margin(1e-9));
  const double rms = std::sqrt((3.0 * 100.0 + 1.0 * 100.0 / 3.0) / 4.0) * 1e-3;
  CHECK(figures.judged.rms_error == Approx(rms).epsilon(0.01));
  CHECK(figures.readings[1].second.rms_error == Approx(figures.judged.rms_error));
}

TEST_CASE("held way-points show a ball that follows the interpolated path without error as late") {
  // the error to the held point grows from 0 to 20 mm in every interval: its mean square is
  // (20 mm)²/3
  const Figures figures = evaluate(follower(0.0, 43.0), kThereAndBack, {});
  CHECK(figures.judged.max_error < 1e-9);
  REQUIRE(figures.readings.size() == 2);
  CHECK(figures.readings[0].second.rms_error == Approx(0.02 / std::sqrt(3.0)).epsilon(0.01));
  CHECK(figures.readings[0].second.max_error == Approx(0.02).epsilon(0.02));
}

TEST_CASE("criteria on a path look at the time after its first second") {
  Series series = follower(0.0, 13.0);
  for (SceneRow& row : series.scene) {
    if (row.time_ns < 4'000 * kMs) row.p_WB[0].y() += 0.05;
  }
  const std::vector<Limit> limits{{"path_error_max_m", {}, 0.02}, {"path_error_rms_m", {}, 0.01}};
  const Figures figures = evaluate(series, kThereAndBack, limits);
  REQUIRE(figures.objects.at(0).max_error == Approx(0.05));
  for (const CriterionResult& result : figures.criteria) {
    CHECK(result.value < 1e-9);
    CHECK(result.met);
  }
  const Series late = follower(1.5, 43.0);  // 30 mm
  CHECK_FALSE(evaluate(late, kThereAndBack, {limits[0]}).criteria.at(0).met);
}

TEST_CASE("a line is done when all balls are past its end, and the worst ball is judged") {
  const c3rt::task::Line line{0.55, -0.01, -0.1, 0.08};
  Series series;
  series.plan.push_back({0, 0, 0, true, false, false, 0.001});
  for (int i = 0; i <= 1000; ++i) {  // both at 0.05 m/s; the second is 0.1 m behind and 5 mm beside
    SceneRow row{};
    row.time_ns = i * 10 * kMs;
    row.object_count = 2;
    row.p_WB[0] = {0.55, 0.1 - 0.0005 * i, 0.0};
    row.p_WB[1] = {0.555, 0.2 - 0.0005 * i, 0.0};
    series.scene.push_back(row);
  }
  const Figures figures = evaluate(series, line,
                                   {{"path_error_max_m", {}, 0.004},
                                    {"arrival_error_max_m", {}, 0.0051},
                                    {"end_error_max_m", {}, 0.004},
                                    {"balls_arrived", 2.0, {}}});
  CHECK(figures.loops_completed == 1);
  CHECK(figures.turns == 2.0);
  REQUIRE(figures.loop_times.size() == 1);
  CHECK(figures.loop_times[0] == Approx(6.0).margin(0.011));  // 0.3 m at 0.05 m/s
  CHECK(figures.judged.max_error == Approx(0.005));
  CHECK_FALSE(figures.criteria.at(0).met);
  CHECK(figures.objects.at(0).arrived_after == Approx(4.0).margin(0.011));
  CHECK(figures.objects.at(1).arrived_after == Approx(6.0).margin(0.011));
  CHECK(figures.objects.at(1).arrival_error == Approx(0.005));
  CHECK(figures.criteria.at(1).met);
  CHECK_FALSE(figures.criteria.at(2).met);
  CHECK(figures.criteria.at(3).met);

  for (SceneRow& row : series.scene) row.p_WB[1].y() = 0.2;  // the second stays
  const Figures stuck =
      evaluate(series, line, {{"arrival_error_max_m", {}, 1.0}, {"balls_arrived", 2.0, {}}});
  CHECK_FALSE(stuck.criteria.at(0).met);  // one has no arrival
  CHECK_FALSE(stuck.criteria.at(1).met);
  CHECK(stuck.loops_completed == 0);
  CHECK(stuck.turns == 1.0);
}

TEST_CASE("without a plan that rolls there is nothing to count") {
  Series series = orbit(kCircle.center, 0.1, 0.05, 40.0);
  series.plan.clear();
  const Figures figures = evaluate(series, kCircle, {{"loops_completed", 1.0, {}}});
  REQUIRE(figures.loops_completed == 0);
  REQUIRE_FALSE(figures.criteria.at(0).met);
}

TEST_CASE("the way from exposure to torque ends at the first command of each plan") {
  Series series;
  series.plan = {{20 * kMs, 0, 5 * kMs, true, false, false, 0.001},
                 {33 * kMs, 0, 18 * kMs, true, true, false, 0.001}};
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  series.command = {{21 * kMs, 20 * kMs, 5 * kMs, 20 * kMs, true, none},
                    {22 * kMs, 21 * kMs, 5 * kMs, 20 * kMs, true, none},  // the same plan again
                    {36 * kMs, 35 * kMs, 18 * kMs, 33 * kMs, true, none}};
  const Latencies measured = latencies(series);
  REQUIRE(measured.exposure_to_plan.size() == 2);
  REQUIRE(measured.exposure_to_plan[0] == Approx(0.015));
  REQUIRE(measured.exposure_to_plan[1] == Approx(0.015));
  REQUIRE(measured.exposure_to_torque.size() == 2);
  REQUIRE(measured.exposure_to_torque[0] == Approx(0.016));
  REQUIRE(measured.exposure_to_torque[1] == Approx(0.018));
  REQUIRE(evaluate(series, kCircle, {}).overruns == 1);
}

TEST_CASE(
    "vision errors compare with the truth at the exposure, and unanswered exposures count as "
    "dropped") {
  Series series;
  for (int i = 0; i <= 10; ++i) {
    SceneRow row{};
    row.time_ns = i * 10 * kMs;
    row.exposure = true;
    row.object_count = 1;
    row.p_WB[0] = {0.01 * i, 0.0, 0.0};
    series.scene.push_back(row);
    if (i == 4 || i == 7) continue;  // dropped
    series.estimate.push_back({row.time_ns + 5 * kMs, row.time_ns, 0, true, i % 2 == 0 ? 3 : 2,
                               row.p_WB[0] + Eigen::Vector3d(0.0, 0.0008, 0.0)});
  }
  // between two rows of truth: interpolated
  series.estimate.push_back({103 * kMs, 95 * kMs, 0, true, 3, {0.095, 0.0008, 0.0}});
  const Figures figures = evaluate(series, kCircle, {});
  REQUIRE(figures.vision_error.p50 == Approx(0.0008));
  REQUIRE(figures.vision_error.max == Approx(0.0008));
  REQUIRE(figures.dropped_frames == 2);
  REQUIRE(std::isnan(figures.vision_angle_error.p50));  // nobody measured how it lies
}

TEST_CASE("vision errors of an orientation are angles to the truth at the exposure") {
  const auto about_z = [](double angle) {
    return Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
  };
  Series series;
  for (int i = 0; i <= 10; ++i) {
    SceneRow row{};
    row.time_ns = i * 10 * kMs;
    row.object_count = 1;
    row.q_WB[0] = about_z(0.1 * i);
    series.scene.push_back(row);
  }
  EstimateRow estimate{50 * kMs, 45 * kMs, 0, true, 3, Eigen::Vector3d::Zero()};
  estimate.q_measured = about_z(0.45 + 0.02);  // between two rows of truth
  series.estimate.push_back(estimate);
  estimate.q_measured.coeffs() *= -1.0;  // the same orientation
  series.estimate.push_back(estimate);
  const Figures figures = evaluate(series, kCircle, {});
  REQUIRE(figures.vision_angle_error.p50 == Approx(0.02));
  REQUIRE(figures.vision_angle_error.max == Approx(0.02));
}

TEST_CASE("quantiles are samples by nearest rank") {
  std::vector<double> samples;
  for (int i = 100; i >= 1; --i) samples.push_back(i);
  const Spread figures = spread(samples);
  REQUIRE(figures.p50 == 50.0);
  REQUIRE(figures.p95 == 95.0);
  REQUIRE(figures.p99 == 99.0);
  REQUIRE(figures.max == 100.0);
  REQUIRE(std::isnan(spread({}).p50));
}

TEST_CASE(
    "the lowest success rate is that of the time under command, and reflexes keep their error "
    "bits") {
  Series series;
  CommandRow command{};
  command.time_ns = 100 * kMs;
  command.tracking = true;
  series.command = {command};
  StateRow state{};
  state.time_ns = 50 * kMs;
  state.success_rate = 0.0;  // nobody commands yet
  series.state.push_back(state);
  state.time_ns = 150 * kMs;
  state.success_rate = 0.97;
  state.errors = 2;
  series.state.push_back(state);
  state.time_ns = 160 * kMs;
  state.success_rate = 0.99;
  state.reflex = true;
  state.errors = 4;
  series.state.push_back(state);
  const Figures figures = evaluate(series, kCircle, {});
  REQUIRE(figures.success_rate_min == Approx(0.97));
  REQUIRE(figures.error_bits == 4);
}
