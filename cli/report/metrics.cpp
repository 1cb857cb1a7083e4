#include "cli/report/metrics.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_set>

namespace c3rt::cli {
namespace {

constexpr double kNs = 1e-9;                            // [s]
constexpr std::int64_t kSettling = 1'000'000'000;       // first second of tracking [ns]
constexpr std::int64_t kLargestSceneGap = 50'000'000;   // truth is not interpolated over more [ns]
constexpr double kWideBand = 0.02, kNarrowBand = 0.01;  // [m]

double seconds(std::int64_t duration_ns) { return static_cast<double>(duration_ns) * kNs; }

double wrap(double angle) { return std::remainder(angle, 2.0 * M_PI); }

/// Figures of one ball over the part of the recording that begins at from_ns; each row holds until
/// the next.
BallFigures ball_figures(const Series& series, const Circle& circle, int ball,
                         std::int64_t from_ns) {
  struct Weighted {
    double error;
    double duration;
  };
  std::vector<Weighted> rows;
  double total = 0.0, squares = 0.0, wide = 0.0, narrow = 0.0;
  for (std::size_t i = 0; i + 1 < series.scene.size(); ++i) {
    const SceneRow& row = series.scene[i];
    if (row.time_ns < from_ns || ball >= row.ball_count) continue;
    const double error = path_error(circle, row.p_WB[static_cast<std::size_t>(ball)]);
    const double duration = seconds(series.scene[i + 1].time_ns - row.time_ns);
    rows.push_back({error, duration});
    total += duration;
    squares += error * error * duration;
    wide += error <= kWideBand ? duration : 0.0;
    narrow += error <= kNarrowBand ? duration : 0.0;
  }
  BallFigures figures;
  if (total <= 0.0) return figures;
  std::sort(rows.begin(), rows.end(),
            [](const Weighted& a, const Weighted& b) { return a.error < b.error; });
  double below = 0.0;
  for (const Weighted& row : rows) {
    below += row.duration;
    if (below >= 0.95 * total) {
      figures.p95_error = row.error;
      break;
    }
  }
  figures.rms_error = std::sqrt(squares / total);
  figures.max_error = rows.back().error;
  figures.in_band_2cm = wide / total;
  figures.in_band_1cm = narrow / total;
  return figures;
}

/// Rows per second between the first and the last one; kNone for fewer than two.
template <typename Row>
double rate(const std::vector<Row>& rows) {
  if (rows.size() < 2 || rows.back().time_ns <= rows.front().time_ns) return kNone;
  return static_cast<double>(rows.size() - 1) / seconds(rows.back().time_ns - rows.front().time_ns);
}

/// True position of a ball at time_ns, linear between the rows around it; nothing outside or over a
/// gap.
std::optional<Eigen::Vector3d> truth(const Series& series, int ball, std::int64_t time_ns) {
  const auto after =
      std::lower_bound(series.scene.begin(), series.scene.end(), time_ns,
                       [](const SceneRow& row, std::int64_t t) { return row.time_ns < t; });
  const auto index = static_cast<std::size_t>(ball);
  if (after == series.scene.end() || ball < 0 || ball >= after->ball_count) return std::nullopt;
  if (after->time_ns == time_ns) return after->p_WB[index];
  if (after == series.scene.begin()) return std::nullopt;
  const auto before = std::prev(after);
  if (after->time_ns - before->time_ns > kLargestSceneGap || ball >= before->ball_count)
    return std::nullopt;
  const double share =
      seconds(time_ns - before->time_ns) / seconds(after->time_ns - before->time_ns);
  return (1.0 - share) * before->p_WB[index] + share * after->p_WB[index];
}

void add_vision(const Series& series, Figures& figures) {
  std::vector<EstimateRow> valid;
  std::vector<double> errors;
  std::unordered_set<std::int64_t> answered;
  double cameras = 0.0;
  for (const EstimateRow& row : series.estimate) {
    answered.insert(row.exposure_ns);
    if (!row.valid) continue;
    valid.push_back(row);
    cameras += row.cameras_used;
    if (const auto p_WB = truth(series, row.ball, row.exposure_ns)) {
      errors.push_back((row.p_measured - *p_WB).norm());
    }
  }
  figures.vision_error = spread(std::move(errors));
  if (series.estimate.empty()) return;
  if (!valid.empty()) figures.cameras_used_mean = cameras / static_cast<double>(valid.size());
  // one estimate per exposure and ball: the rate is that of the first ball
  valid.erase(std::remove_if(valid.begin(), valid.end(),
                             [](const EstimateRow& row) { return row.ball != 0; }),
              valid.end());
  figures.vision_rate = rate(valid);
  const std::int64_t first = series.estimate.front().exposure_ns,
                     last = series.estimate.back().exposure_ns;
  for (const SceneRow& row : series.scene) {
    const bool due = row.exposure && row.time_ns >= first && row.time_ns <= last;
    if (due && answered.count(row.time_ns) == 0) ++figures.dropped_frames;
  }
}

void add_criteria(const std::vector<Limit>& limits, const BallFigures& after_quarter,
                  Figures& figures) {
  const auto value_of = [&](const std::string& name) {
    if (name == "loops_completed") return static_cast<double>(figures.loops_completed);
    if (name == "max_loop_time_s") {
      return figures.loop_times.empty()
                 ? kNone
                 : *std::max_element(figures.loop_times.begin(), figures.loop_times.end());
    }
    if (name == "in_band_2cm") return after_quarter.in_band_2cm;
    if (name == "in_band_1cm") return after_quarter.in_band_1cm;
    if (name == "tracking_error_p95_m") return figures.tracking_error.p95;
    if (name == "vision_error_p95_m") return figures.vision_error.p95;
    return kNone;
  };
  figures.criteria = judge(limits, value_of);
}

}  // namespace

std::vector<CriterionResult> judge(const std::vector<Limit>& limits,
                                   const std::function<double(const std::string&)>& value_of) {
  std::vector<CriterionResult> results;
  for (const Limit& limit : limits) {
    const double value = value_of(limit.name);
    // comparisons with kNone are false: what the run does not give is not met
    if (limit.min) results.push_back({limit.name, value, *limit.min, value >= *limit.min});
    if (limit.max) results.push_back({limit.name, value, *limit.max, value <= *limit.max});
  }
  return results;
}

void LoopCounter::add(double time, const Eigen::Vector2d& p_WB) {
  const Eigen::Vector2d arm = p_WB - circle_.center;
  const double sign = circle_.clockwise ? 1.0 : -1.0;
  const double alpha = sign * std::atan2(arm.x(), arm.y());
  if (!started_) {
    started_ = true;
    last_alpha_ = alpha;
    last_time_ = loop_start_ = time;
    return;
  }
  const double step = wrap(alpha - last_alpha_);
  // the instant at which the angle passed a mark between the last position and this one
  const auto passed = [&](double mark) {
    return last_time_ + (time - last_time_) * (mark - angle_) / step;
  };
  if (std::isnan(quarter_time_) && angle_ + step >= 0.5 * M_PI) quarter_time_ = passed(0.5 * M_PI);
  const double next_mark = 2.0 * M_PI * (completed() + 1);
  if (angle_ + step >= next_mark) {
    const double at = passed(next_mark);
    times_.push_back(at - loop_start_);
    loop_start_ = at;
  }
  angle_ += step;
  last_alpha_ = alpha;
  last_time_ = time;
}

double path_error(const Circle& circle, const Eigen::Vector3d& p_WB) {
  return std::abs((p_WB.head<2>() - circle.center).norm() - circle.radius);
}

Spread spread(std::vector<double> samples) {
  if (samples.empty()) return {};
  std::sort(samples.begin(), samples.end());
  const auto quantile = [&](double share) {
    const auto rank =
        static_cast<std::size_t>(std::ceil(share * static_cast<double>(samples.size())));
    return samples[std::max<std::size_t>(rank, 1) - 1];
  };
  return {quantile(0.50), quantile(0.95), quantile(0.99), samples.back()};
}

std::int64_t start_ns(const Series& series) {
  return series.scene.empty() ? 0 : series.scene.front().time_ns;
}

TrackingError tracking_error(const Series& series) {
  TrackingError result;
  std::int64_t tracking_since = 0;
  for (const CommandRow& command : series.command) {
    if (!command.tracking) continue;
    if (tracking_since == 0) tracking_since = command.time_ns;
    if (command.time_ns - tracking_since < kSettling) continue;
    const auto state =
        std::lower_bound(series.state.begin(), series.state.end(), command.state_ns,
                         [](const StateRow& row, std::int64_t t) { return row.time_ns < t; });
    if (state == series.state.end() || state->time_ns != command.state_ns)
      continue;  // lost on the way
    result.time.push_back(seconds(state->time_ns - start_ns(series)));
    result.error.push_back((state->p_WE - command.p_WE_desired).norm());
  }
  return result;
}

Latencies latencies(const Series& series) {
  Latencies result;
  for (const PlanRow& plan : series.plan) {
    if (plan.exposure_ns != 0)
      result.exposure_to_plan.push_back(seconds(plan.time_ns - plan.exposure_ns));
  }
  std::int64_t last_plan_ns = 0;
  for (const CommandRow& command : series.command) {
    if (command.state_ns != 0)
      result.state_to_command.push_back(seconds(command.time_ns - command.state_ns));
    const bool first_of_plan = command.plan_ns != 0 && command.plan_ns != last_plan_ns;
    if (first_of_plan && command.exposure_ns != 0) {
      result.exposure_to_torque.push_back(seconds(command.time_ns - command.exposure_ns));
    }
    last_plan_ns = command.plan_ns;
  }
  return result;
}

Figures evaluate(const Series& series, const Circle& circle, const std::vector<Limit>& limits) {
  Figures figures;
  const std::int64_t zero = start_ns(series);
  if (!series.scene.empty()) figures.duration = seconds(series.scene.back().time_ns - zero);

  const auto first_rolling = std::find_if(series.plan.begin(), series.plan.end(),
                                          [](const PlanRow& plan) { return plan.rolling; });
  BallFigures after_quarter;
  if (first_rolling != series.plan.end()) {
    const std::int64_t from_ns = first_rolling->time_ns;
    figures.task_start = seconds(from_ns - zero);
    LoopCounter loops(circle);
    int balls = 0;
    for (const SceneRow& row : series.scene) {
      balls = std::max(balls, row.ball_count);
      if (row.time_ns >= from_ns && row.ball_count > 0)
        loops.add(seconds(row.time_ns - zero), row.p_WB[0].head<2>());
    }
    figures.loops_completed = loops.completed();
    figures.loop_times = loops.times();
    figures.turns = loops.turns();
    for (int ball = 0; ball < balls; ++ball)
      figures.balls.push_back(ball_figures(series, circle, ball, from_ns));
    if (!std::isnan(loops.quarter_time())) {
      const std::int64_t quarter_ns =
          zero + static_cast<std::int64_t>(std::llround(loops.quarter_time() / kNs));
      after_quarter = ball_figures(series, circle, 0, quarter_ns);
    }
  }

  figures.tracking_error = spread(tracking_error(series).error);
  std::vector<double> solve_times;
  for (const PlanRow& plan : series.plan) {
    if (plan.solve_time > 0.0) solve_times.push_back(plan.solve_time);
    figures.overruns += plan.truncated ? 1 : 0;
    figures.fallbacks += plan.fallback ? 1 : 0;
  }
  figures.planner_rate = rate(series.plan);
  figures.solve_time = spread(std::move(solve_times));
  figures.impedance_rate = rate(series.command);
  add_vision(series, figures);

  Latencies measured = latencies(series);
  figures.state_to_command = spread(std::move(measured.state_to_command));
  figures.exposure_to_plan = spread(std::move(measured.exposure_to_plan));
  figures.exposure_to_torque = spread(std::move(measured.exposure_to_torque));

  const auto first_tracking = std::find_if(series.command.begin(), series.command.end(),
                                           [](const CommandRow& row) { return row.tracking; });
  for (const StateRow& row : series.state) {
    if (row.reflex) figures.error_bits |= row.errors;
    const bool commanded =
        first_tracking != series.command.end() && row.time_ns >= first_tracking->time_ns;
    if (commanded) figures.success_rate_min = std::fmin(figures.success_rate_min, row.success_rate);
  }
  add_criteria(limits, after_quarter, figures);
  return figures;
}

}  // namespace c3rt::cli
