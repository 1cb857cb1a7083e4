#include "cli/report/metrics.hpp"

#include <algorithm>
#include <cmath>

#include "cli/report/tracking.hpp"
#include "controller/base/quantile.hpp"
#include "controller/base/time.hpp"

namespace c3rt::cli {
namespace {

constexpr std::int64_t kLargestSceneGap = 50'000'000;  // truth is not interpolated over more [ns]
constexpr double kNarrowBand = 0.01;                   // [m]

using base::seconds;

/// Figures of one object from `judged_from` seconds after the task began; each row holds until the
/// next.
ObjectFigures object_figures(const Series& series, const task::Task& task, int object,
                             std::int64_t start_ns, double judged_from) {
  struct Weighted {
    double error;
    double duration;
  };
  LongRows<Weighted> rows(series.folder);
  double total = 0.0, squares = 0.0, wide = 0.0, narrow = 0.0;
  for (std::size_t i = 0; i + 1 < series.scene.size(); ++i) {
    const SceneRow& row = series.scene[i];
    const double elapsed = seconds(row.time_ns - start_ns);
    if (!(elapsed >= judged_from) || object >= row.object_count) continue;
    const double error =
        task.error(elapsed, row.p_WB[static_cast<std::size_t>(object)].head<2>(), object);
    const double duration = seconds(series.scene[i + 1].time_ns - row.time_ns);
    rows.push_back({error, duration});
    total += duration;
    squares += error * error * duration;
    wide += error <= kBand ? duration : 0.0;
    narrow += error <= kNarrowBand ? duration : 0.0;
  }
  ObjectFigures figures;
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

/// When and where one object arrived, and where it ended up.
void add_arrival(const Series& series, const task::Task& task, int object, std::int64_t start_ns,
                 ObjectFigures& figures) {
  for (const SceneRow& row : series.scene) {
    if (row.time_ns < start_ns || object >= row.object_count) continue;
    const Eigen::Vector2d at = row.p_WB[static_cast<std::size_t>(object)].head<2>();
    figures.end_error = task.error(0.0, at, object);
    if (std::isnan(figures.arrived_after) && task.arrived(at).value_or(false)) {
      figures.arrived_after = seconds(row.time_ns - start_ns);
      figures.arrival_error = figures.end_error;
    }
  }
}

/// The largest of a figure over the objects; kNone where one object has none.
double largest(const std::vector<ObjectFigures>& objects, double ObjectFigures::*figure) {
  double result = objects.empty() ? kNone : objects.front().*figure;
  for (const ObjectFigures& object : objects) {
    if (!(result >= object.*figure)) result = std::isnan(result) ? kNone : object.*figure;
  }
  return result;
}

/// The worst of each figure over the objects; kNone where one object has none.
ObjectFigures worst_figures(const Series& series, const task::Task& task, int objects,
                            std::int64_t start_ns, double judged_from) {
  if (objects == 0) return {};
  ObjectFigures worst = object_figures(series, task, 0, start_ns, judged_from);
  for (int object = 1; object < objects; ++object) {
    const ObjectFigures figures = object_figures(series, task, object, start_ns, judged_from);
    worst.rms_error = std::max(worst.rms_error, figures.rms_error);
    worst.p95_error = std::max(worst.p95_error, figures.p95_error);
    worst.max_error = std::max(worst.max_error, figures.max_error);
    worst.in_band_2cm = std::min(worst.in_band_2cm, figures.in_band_2cm);
    worst.in_band_1cm = std::min(worst.in_band_1cm, figures.in_band_1cm);
  }
  return worst;
}

/// Rows per second between the first and the last one; kNone for fewer than two.
template <typename Row>
double rate(const LongRows<Row>& rows) {
  if (rows.size() < 2 || rows.back().time_ns <= rows.front().time_ns) return kNone;
  return static_cast<double>(rows.size() - 1) / seconds(rows.back().time_ns - rows.front().time_ns);
}

struct TruePose {
  Eigen::Vector3d p_WB;
  Eigen::Quaternion<double, Eigen::DontAlign> q_WB;
};

/// Of an object at time_ns, between the rows around it; nothing outside or over a gap.
std::optional<TruePose> truth(const Series& series, int object, std::int64_t time_ns) {
  const auto* const after =
      std::lower_bound(series.scene.begin(), series.scene.end(), time_ns,
                       [](const SceneRow& row, std::int64_t t) { return row.time_ns < t; });
  const auto index = static_cast<std::size_t>(object);
  if (after == series.scene.end() || object < 0 || object >= after->object_count)
    return std::nullopt;
  if (after->time_ns == time_ns) return TruePose{after->p_WB[index], after->q_WB[index]};
  if (after == series.scene.begin()) return std::nullopt;
  const auto* const before = std::prev(after);
  if (after->time_ns - before->time_ns > kLargestSceneGap || object >= before->object_count)
    return std::nullopt;
  const double share =
      seconds(time_ns - before->time_ns) / seconds(after->time_ns - before->time_ns);
  return TruePose{(1.0 - share) * before->p_WB[index] + share * after->p_WB[index],
                  before->q_WB[index].slerp(share, after->q_WB[index])};
}

void add_vision(const Series& series, Figures& figures) {
  // one estimate per exposure and object: the rate is that of the first object
  LongRows<EstimateRow> of_first(series.folder);
  LongRows<double> errors(series.folder), angle_errors(series.folder);
  LongRows<std::int64_t> answered(series.folder);
  std::size_t valid = 0;
  double cameras = 0.0;
  for (const EstimateRow& row : series.estimate) {
    answered.push_back(row.exposure_ns);
    if (!row.valid) continue;
    ++valid;
    if (row.object == 0) of_first.push_back(row);
    cameras += row.sensors_used;
    if (const auto pose = truth(series, row.object, row.exposure_ns)) {
      errors.push_back((row.p_measured - pose->p_WB).norm());
      if (row.q_measured.squaredNorm() > 0.0)
        angle_errors.push_back(row.q_measured.angularDistance(pose->q_WB));
    }
  }
  figures.vision_error = spread_of(errors);
  figures.vision_angle_error = spread_of(angle_errors);
  if (series.estimate.empty()) return;
  if (valid > 0) figures.cameras_used_mean = cameras / static_cast<double>(valid);
  figures.vision_rate = rate(of_first);
  std::sort(answered.begin(), answered.end());
  const std::int64_t first = series.estimate.front().exposure_ns,
                     last = series.estimate.back().exposure_ns;
  for (const SceneRow& row : series.scene) {
    const bool due = row.exposure && row.time_ns >= first && row.time_ns <= last;
    if (due && !std::binary_search(answered.begin(), answered.end(), row.time_ns))
      ++figures.dropped_frames;
  }
}

void add_course(const Series& series, const task::Task& task,
                const std::vector<plant::Push>& pushes, Figures& figures) {
  figures.unit = task.unit();
  const auto start_ns = task_start_ns(series);
  if (!start_ns) return;
  figures.task_start = seconds(*start_ns - cli::start_ns(series));
  Course course(task);
  int objects = 0;
  for (const SceneRow& row : series.scene) {
    objects = std::max(objects, row.object_count);
    if (row.time_ns >= *start_ns) course.add(seconds(row.time_ns - *start_ns), row);
  }
  figures.loops_completed = course.progress().completed();
  figures.loop_times = course.progress().times();
  figures.turns = course.progress().amount();
  figures.task = course.progress().results();
  for (int object = 0; object < objects; ++object)
    figures.objects.push_back(object_figures(series, task, object, *start_ns, 0.0));
  if (task.arrived(task.middle())) {
    for (int object = 0; object < objects; ++object)
      add_arrival(series, task, object, *start_ns,
                  figures.objects[static_cast<std::size_t>(object)]);
  }
  const double from = course.progress().judged_from();
  figures.judged = worst_figures(series, task, objects, *start_ns, from);
  figures.out_of_band = excursion_figures(series, task, from, pushes);
  for (const auto& [name, reading] : task.readings())
    figures.readings.emplace_back(name, worst_figures(series, reading, objects, *start_ns, from));
}

void add_criteria(const std::vector<Limit>& limits, Figures& figures) {
  const auto value_of = [&](const std::string& name) {
    if (name == "loops_completed") return static_cast<double>(figures.loops_completed);
    if (name == "max_loop_time_s") {
      return figures.loop_times.empty()
                 ? kNone
                 : *std::max_element(figures.loop_times.begin(), figures.loop_times.end());
    }
    if (name == "in_band_2cm") return figures.judged.in_band_2cm;
    if (name == "in_band_1cm") return figures.judged.in_band_1cm;
    if (name == "longest_excursion_s") return figures.out_of_band.longest;
    if (name == "largest_excursion_m") return figures.out_of_band.largest;
    if (name == "ended_in_band") {
      const std::optional<bool> ended = figures.out_of_band.ended_in_band;
      return ended ? (*ended ? 1.0 : 0.0) : kNone;
    }
    if (name == "path_error_rms_m") return figures.judged.rms_error;
    if (name == "path_error_p95_m") return figures.judged.p95_error;
    if (name == "path_error_max_m") return figures.judged.max_error;
    if (name == "arrival_error_max_m")
      return largest(figures.objects, &ObjectFigures::arrival_error);
    if (name == "end_error_max_m") return largest(figures.objects, &ObjectFigures::end_error);
    if (name == "tracking_error_p95_m") return figures.tracking_error.p95;
    if (name == "tracking_error_max_m") return figures.tracking_error.max;
    if (name == "vision_error_p95_m") return figures.vision_error.p95;
    for (const auto& [own, value] : figures.task) {
      if (name == own) return value;
    }
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

namespace {

template <typename Samples>
Spread sorted_spread(Samples& samples) {
  if (samples.empty()) return {};
  std::sort(samples.begin(), samples.end());
  const auto quantile = [&samples](double share) {
    return samples[base::nearest_rank(samples.size(), share) - 1];
  };
  return {quantile(0.50), quantile(0.95), quantile(0.99), samples.back()};
}

}  // namespace

Spread spread(std::vector<double> samples) { return sorted_spread(samples); }
Spread spread_of(LongRows<double>& samples) { return sorted_spread(samples); }

std::int64_t start_ns(const Series& series) {
  return series.scene.empty() ? 0 : series.scene.front().time_ns;
}

Latencies latencies(const Series& series) {
  Latencies result{LongRows<double>(series.folder), LongRows<double>(series.folder),
                   LongRows<double>(series.folder)};
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

const CommandRow* first_tracking(const Series& series) {
  return std::find_if(series.command.begin(), series.command.end(),
                      [](const CommandRow& row) { return row.tracking; });
}

Figures evaluate(const Series& series, const task::Task& task, const std::vector<Limit>& limits,
                 const std::vector<plant::Push>& pushes) {
  Figures figures;
  if (!series.scene.empty())
    figures.duration = seconds(series.scene.back().time_ns - start_ns(series));
  add_course(series, task, pushes, figures);
  TrackingErrors tracking = tracking_errors(series);
  figures.tracking_error = spread_of(tracking.task.error);
  figures.approach_error = spread_of(tracking.approach.error);
  LongRows<double> solve_times(series.folder);
  for (const PlanRow& plan : series.plan) {
    if (plan.solve_time > 0.0) solve_times.push_back(plan.solve_time);
    figures.overruns += plan.truncated ? 1 : 0;
    figures.fallbacks += plan.fallback ? 1 : 0;
  }
  figures.planner_rate = rate(series.plan);
  figures.solve_time = spread_of(solve_times);
  figures.impedance_rate = rate(series.command);
  add_vision(series, figures);

  Latencies measured = latencies(series);
  figures.state_to_command = spread_of(measured.state_to_command);
  figures.exposure_to_plan = spread_of(measured.exposure_to_plan);
  figures.exposure_to_torque = spread_of(measured.exposure_to_torque);

  const CommandRow* const first = first_tracking(series);
  for (const StateRow& row : series.state) {
    if (row.reflex) figures.error_bits |= row.errors;
    const bool commanded = first != series.command.end() && row.time_ns >= first->time_ns;
    if (commanded) figures.success_rate_min = std::fmin(figures.success_rate_min, row.success_rate);
  }
  add_criteria(limits, figures);
  return figures;
}

}  // namespace c3rt::cli
