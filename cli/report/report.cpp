#include "cli/report/report.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/report/json.hpp"

namespace c3rt::cli {
namespace {

using nlohmann::ordered_json;

/// "-" for what the run did not give; else the value in a smaller unit.
std::string shown(double value, double per_unit, int digits) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value * per_unit, digits) : "-";
}

std::string shown(const Spread& spread, double per_unit, int digits) {
  return fmt::format("p50 {}  p95 {}  max {}", shown(spread.p50, per_unit, digits),
                     shown(spread.p95, per_unit, digits), shown(spread.max, per_unit, digits));
}

std::string words_of(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

ordered_json to_json(const ObjectFigures& object) {
  return {{"rms_error_m", number(object.rms_error)},
          {"p95_error_m", number(object.p95_error)},
          {"max_error_m", number(object.max_error)},
          {"in_band_2cm", number(object.in_band_2cm)},
          {"in_band_1cm", number(object.in_band_1cm)},
          {"arrived_after_s", number(object.arrived_after)},
          {"arrival_error_m", number(object.arrival_error)},
          {"end_error_m", number(object.end_error)}};
}

std::string shown(const ObjectFigures& object) {
  constexpr double kMilli = 1e3, kPercent = 1e2;
  return fmt::format("rms {} mm  p95 {} mm  max {} mm  in 2 cm {} %  in 1 cm {} %",
                     shown(object.rms_error, kMilli, 1), shown(object.p95_error, kMilli, 1),
                     shown(object.max_error, kMilli, 1), shown(object.in_band_2cm, kPercent, 1),
                     shown(object.in_band_1cm, kPercent, 1));
}

ordered_json to_json(const ExcursionFigures& figures) {
  ordered_json excursions = ordered_json::array(), pushes = ordered_json::array();
  for (const Excursion& e : figures.excursions) {
    excursions.push_back({{"start_s", number(e.start)},
                          {"duration_s", number(e.duration)},
                          {"largest_m", number(e.largest)},
                          {"returned", e.returned}});
  }
  for (const PushFigures& p : figures.pushes) {
    pushes.push_back({{"time_s", number(p.push.time)},
                      {"object", p.push.object},
                      {"impulse_n_s", {p.push.impulse.x(), p.push.impulse.y()}},
                      {"out_of_band_s", number(p.out_of_band)},
                      {"largest_m", number(p.largest)},
                      {"returned", p.returned}});
  }
  ordered_json ended;
  if (figures.ended_in_band) ended = *figures.ended_in_band;
  return {{"longest_s", number(figures.longest)},
          {"largest_m", number(figures.largest)},
          {"ended_in_band", ended},
          {"excursions", excursions},
          {"pushes", pushes}};
}

/// One line, empty where nothing was judged.
std::string shown(const ExcursionFigures& figures) {
  if (!figures.ended_in_band) return "";
  std::string text =
      fmt::format("{} times, longest {} s, farthest {} mm, {} at the end",
                  figures.excursions.size(), shown(figures.longest, 1, 1),
                  shown(figures.largest, 1e3, 0), *figures.ended_in_band ? "inside" : "OUTSIDE");
  const auto returned = std::count_if(figures.pushes.begin(), figures.pushes.end(),
                                      [](const PushFigures& push) { return push.returned; });
  if (!figures.pushes.empty())
    text += fmt::format(", back after {} of {} pushes", returned, figures.pushes.size());
  return text;
}

}  // namespace

bool all_met(const std::vector<CriterionResult>& criteria) {
  return std::all_of(criteria.begin(), criteria.end(),
                     [](const CriterionResult& c) { return c.met; });
}

ordered_json to_json(const Report& report) {
  const Figures& figures = report.figures;
  ordered_json objects = ordered_json::array();
  for (const ObjectFigures& object : figures.objects) objects.push_back(to_json(object));
  ordered_json path;  // null but for a task in time
  for (const auto& [name, reading] : figures.readings) path[name] = to_json(reading);
  ordered_json task;  // null but for a task with figures of its own
  for (const auto& [name, value] : figures.task) task[name] = number(value);
  ordered_json guests = ordered_json::array();
  for (const Guest& guest : report.guests) guests.push_back(to_json(guest));
  return {
      {"scenario", report.scenario},
      {"seed", report.seed},
      {"clock", report.clock},
      {"duration_s", number(figures.duration)},
      {"result", report.result},
      {"criteria", to_json(figures.criteria)},
      {"loops_completed", figures.loops_completed},
      {"loop_times_s", figures.loop_times},
      {"task", task},
      {"objects", objects},
      {"judged", to_json(figures.judged)},
      {"path", path},
      {"out_of_band", to_json(figures.out_of_band)},
      {"end_effector",
       {{"tracking_error_m", quantiles(figures.tracking_error)},
        {"approach_error_m", quantiles(figures.approach_error)}}},
      {"planner",
       {{"rate_hz", number(figures.planner_rate)},
        {"solve_time_s", quantiles(figures.solve_time)},
        {"overruns", figures.overruns},
        {"fallbacks", figures.fallbacks}}},
      {"impedance",
       {{"rate_hz", number(figures.impedance_rate)},
        {"wakeup_latency_s", quantiles(report.services.impedance_wakeup)},
        {"compute_s", quantiles(report.services.impedance_compute)},
        {"missed_cycles", report.services.impedance_missed_cycles},
        {"stale_plan_events", report.services.stale_plan_events}}},
      {"vision",
       {{"rate_hz", number(figures.vision_rate)},
        {"error_m", quantiles(figures.vision_error)},
        {"angle_error_rad", quantiles(figures.vision_angle_error)},
        {"dropped_frames", figures.dropped_frames},
        {"cameras_used_mean", number(figures.cameras_used_mean)}}},
      {"latency",
       {{"state_to_command_s", quantiles(figures.state_to_command)},
        {"exposure_to_plan_s", quantiles(figures.exposure_to_plan)},
        {"exposure_to_torque_s", quantiles(figures.exposure_to_torque)}}},
      {"plant",
       {{"real_time_factor", number(report.real_time_factor)},
        {"reflexes", report.reflexes},
        {"success_rate_min", number(figures.success_rate_min)}}},
      {"clients", guests},
      {"log_hash", report.log_hash},
  };
}

std::string summary(const Report& report) {
  const Figures& figures = report.figures;
  constexpr double kMilli = 1e3, kDegrees = 180.0 / M_PI;
  std::string loop_times;
  for (const double time : figures.loop_times) loop_times += fmt::format(" {:.1f}", time);
  std::string text;
  const auto line = [&](const char* name, const std::string& value) {
    text += fmt::format("  {:<22}{}\n", name, value);
  };
  text += fmt::format("{} ({}, seed {}): {}\n", report.scenario, report.clock, report.seed,
                      report.result);
  line("duration", fmt::format("{} s, {} of real time", shown(figures.duration, 1, 1),
                               shown(report.real_time_factor, 1, 2)));
  line(figures.unit.c_str(),
       fmt::format("{:.2f}{}", figures.turns,
                   loop_times.empty() ? "" : ", done in" + loop_times + " s"));
  for (const auto& [name, value] : figures.task)
    line(words_of(name).c_str(), std::isfinite(value) ? fmt::format("{:.4g}", value) : "-");
  for (const ObjectFigures& object : figures.objects) line("object to path", shown(object));
  if (const std::string out = shown(figures.out_of_band); !out.empty()) line("out of 2 cm", out);
  for (const ObjectFigures& object : figures.objects) {
    if (!std::isfinite(object.end_error)) continue;  // of a task without an end
    line("object past the end",
         fmt::format("after {} s, {} mm beside the line; at the end {} mm",
                     shown(object.arrived_after, 1, 1), shown(object.arrival_error, kMilli, 1),
                     shown(object.end_error, kMilli, 1)));
  }
  for (const auto& [name, reading] : figures.readings) line(words_of(name).c_str(), shown(reading));
  line("end effector error", shown(figures.tracking_error, kMilli, 2) + " mm");
  line("way to an object", shown(figures.approach_error, kMilli, 2) + " mm");
  line("planner",
       fmt::format("{} Hz, solve {} ms, {} truncated, {} fallbacks",
                   shown(figures.planner_rate, 1, 1), shown(figures.solve_time, kMilli, 2),
                   figures.overruns, figures.fallbacks));
  line("impedance",
       fmt::format("{} Hz, {} missed cycles, {} stale plans", shown(figures.impedance_rate, 1, 1),
                   report.services.impedance_missed_cycles, report.services.stale_plan_events));
  line("vision",
       fmt::format("{} Hz, error {} mm{}, {} dropped frames", shown(figures.vision_rate, 1, 1),
                   shown(figures.vision_error, kMilli, 2),
                   std::isfinite(figures.vision_angle_error.p50)
                       ? "; " + shown(figures.vision_angle_error, kDegrees, 2) + " degrees"
                       : "",
                   figures.dropped_frames));
  line("exposure to torque", shown(figures.exposure_to_torque, kMilli, 1) + " ms");
  for (const Guest& guest : report.guests) {
    line(("your " + guest.process).c_str(),
         fmt::format("{} of {}, {} Hz, in effect after {} ms", guest.samples, guest.topic,
                     shown(guest.rate, 1, 1), shown(guest.age, kMilli, 1)));
    for (const std::string& problem : guest.problems) line("", problem);
  }
  for (const CriterionResult& c : figures.criteria) {
    line(c.met ? "met" : "NOT MET",
         fmt::format("{}: {} (limit {:g})", c.name,
                     std::isfinite(c.value) ? fmt::format("{:.4g}", c.value) : "-", c.limit));
  }
  return text;
}

}  // namespace c3rt::cli
