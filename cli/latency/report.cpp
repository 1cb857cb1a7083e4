#include "cli/latency/report.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/report/figure.hpp"
#include "cli/report/json.hpp"
#include "cli/report/text_table.hpp"
#include "controller/base/quantile.hpp"
#include "controller/base/time.hpp"

namespace c3rt::cli::latency {
namespace {

using nlohmann::ordered_json;

constexpr double kPerWorst_s = 0.1;  // the picture shows the latest wake-up of so long
constexpr double kNineStep = 0.05;

ordered_json to_json(const Distribution& d) {
  return {{"count", d.count},     {"p50", number(d.p50)},   {"p95", number(d.p95)},
          {"p99", number(d.p99)}, {"p999", number(d.p999)}, {"max", number(d.max)}};
}

std::string milliseconds(double value_s) {
  return std::isfinite(value_s) ? fmt::format("{:.3f}", 1e3 * value_s) : "-";
}

std::string criteria_text(const std::vector<CriterionResult>& criteria) {
  std::string result;
  for (const CriterionResult& c : criteria) {
    result += fmt::format("    {:<8} {}: {} (limit {})\n", c.met ? "met" : "not met", c.name,
                          shown(c.value, 3), shown(c.limit, 3));
  }
  return result;
}

/// Its quantiles over the number of nines: 1 is the 90th percentile, 2 the 99th.
Curve quantile_curve(const Row& row) {
  std::vector<double> sorted = row.samples;
  std::sort(sorted.begin(), sorted.end());
  const double last = std::log10(static_cast<double>(sorted.size()));
  const auto points = static_cast<Eigen::Index>(std::floor(last / kNineStep)) + 1;
  Curve curve{row.name, "", Eigen::VectorXd(points), Eigen::VectorXd(points)};
  for (Eigen::Index i = 0; i < points; ++i) {
    curve.x[i] = static_cast<double>(i) * kNineStep;
    curve.y[i] = 1e3 * base::quantile_nearest(sorted, 1.0 - std::pow(10.0, -curve.x[i]));
  }
  return curve;
}

/// The latest wake-up in each tenth of a second.
Curve worst_curve(const std::string& name, const char* color, const std::vector<Wakeup>& wakeups,
                  std::int64_t start_ns) {
  std::vector<double> worst;
  for (const Wakeup& wakeup : wakeups) {
    const double at = base::seconds(wakeup.deadline_ns - start_ns) / kPerWorst_s;
    const auto index = static_cast<std::size_t>(std::max(at, 0.0));
    if (index >= worst.size()) worst.resize(index + 1, kNone);
    worst[index] = std::fmax(worst[index], 1e3 * base::seconds(wakeup.latency_ns));
  }
  const auto count = static_cast<Eigen::Index>(worst.size());
  return {name, color,
          Eigen::VectorXd::LinSpaced(count, 0.5 * kPerWorst_s,
                                     (static_cast<double>(count) - 0.5) * kPerWorst_s),
          Eigen::Map<const Eigen::VectorXd>(worst.data(), count)};
}

}  // namespace

ordered_json to_json(const Report& report) {
  ordered_json times;
  for (const Row& row : report.rows) times[row.key] = to_json(row.times);
  const Measured& m = report.measured;
  ordered_json stalls = ordered_json::array();
  const auto since_start = [&report](std::int64_t time_ns) {
    return report.loop.empty() ? 0.0 : base::seconds(time_ns - report.loop.front().deadline_ns);
  };
  ordered_json outside = ordered_json::array();
  for (const std::int64_t time_ns : m.missed.outside_ns) outside.push_back(since_start(time_ns));
  for (const Stall& stall : m.stalls) {
    stalls.push_back({{"at_s", since_start(stall.begin_ns)},
                      {"duration_s", base::seconds(stall.end_ns - stall.begin_ns)}});
  }
  return {{"scenario", report.scenario},
          {"profile", report.profile},
          {"duration_s", report.duration},
          {"load", report.load},
          {"machine",
           {{"cores", report.cores},
            {"kernel", report.kernel},
            {"clock_source", report.clock_source},
            {"real_time", report.real_time}}},
          {"times_s", times},
          {"pings", {{"sent", report.pings}, {"lost", report.pings_lost}}},
          {"success_rate",
           {{"states", m.success.states},
            {"average", number(m.success.average)},
            {"minimum", number(m.success.minimum)},
            {"minimum_at_s", since_start(m.success.minimum_ns)}}},
          {"missed_cycles",
           {{"cycles", m.missed.cycles},
            {"missed", m.missed.missed},
            {"within_stalls", m.missed.within_stalls},
            {"share_outside", number(m.missed.share_outside())},
            {"outside_at_s", outside}}},
          {"stalls", stalls},
          {"reflexes", m.reflexes},
          {"verdict", report.judgement.good ? "good" : "not good"},
          {"sentence", report.judgement.sentence},
          {"causes", report.judgement.causes},
          {"criteria", cli::to_json(report.judgement.robot)},
          {"targets", cli::to_json(report.judgement.program)}};
}

std::string text(const Report& report) {
  Rows rows{{"ms", "n", "p50", "p95", "p99", "p99.9", "max"}};
  std::string stage;
  for (const Row& row : report.rows) {
    if (row.stage != stage) rows.push_back({stage = row.stage});
    rows.push_back({"  " + row.name, std::to_string(row.times.count), milliseconds(row.times.p50),
                    milliseconds(row.times.p95), milliseconds(row.times.p99),
                    milliseconds(row.times.p999), milliseconds(row.times.max)});
  }
  const Measured& m = report.measured;
  std::string result =
      fmt::format("{} cores, kernel {}, {}, {} busy thread{}, profile {}, {}\n", report.cores,
                  report.kernel, report.real_time ? "SCHED_FIFO" : "ordinary scheduling",
                  report.load, report.load == 1 ? "" : "s", report.profile, report.scenario);
  result += text_table(rows);
  result += fmt::format("{} pings sent, {} lost\n", report.pings, report.pings_lost);
  result += fmt::format(
      "success rate of the last 100 commands: average {}, minimum {}\n"
      "missed cycles: {} of {}, {} of them within {} stalls that a reference thread saw\n",
      shown(m.success.average, 4), shown(m.success.minimum, 3), m.missed.missed, m.missed.cycles,
      m.missed.within_stalls, m.stalls.size());
  result += "  the robot's criteria\n" + criteria_text(report.judgement.robot);
  result += "  what c3rt promises of itself on a quiet machine\n" +
            criteria_text(report.judgement.program);
  for (const std::string& cause : report.judgement.causes) result += "  " + cause + "\n";
  return result + report.judgement.sentence + "\n";
}

std::string draw(const std::filesystem::path& file, const Report& report) {
  constexpr const char* kNines = "nines: 1 = p90, 2 = p99, 3 = p99.9";
  Panel alone{"Quantiles: the machine alone, and DDS", kNines, "time [ms]", {}, {}, true};
  Panel processes{"Quantiles: with the four processes", kNines, "time [ms]", {}, {}, true};
  for (const Row& row : report.rows) {
    if (row.samples.empty()) continue;
    Panel& panel = row.stage == kProcessStage ? processes : alone;
    panel.curves.push_back(quantile_curve(row));
  }
  Panel worst{"Latest wake-up of each 0.1 s while the four processes ran",
              "time [s]",
              "late [ms]",
              {},
              {},
              true};
  if (!report.loop.empty()) {
    const std::int64_t start_ns = report.loop.front().deadline_ns;
    worst.curves = {worst_curve("reference", kGrey, report.reference, start_ns),
                    worst_curve("1 kHz loop", kBlue, report.loop, start_ns)};
  }
  return cli::draw(
      {{file,
        {fmt::format("c3rt latency: {}", report.judgement.sentence), {alone, processes, worst}}}});
}

}  // namespace c3rt::cli::latency
