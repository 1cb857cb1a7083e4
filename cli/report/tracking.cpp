#include "cli/report/tracking.hpp"

#include <algorithm>

#include "cli/report/metrics.hpp"

namespace c3rt::cli {
namespace {

constexpr double kNs = 1e-9;                       // [s]
constexpr std::int64_t kSettling = 1'000'000'000;  // first second of tracking [ns]

/// The row of this instant; nullptr where it was lost on the way.
template <typename Row>
const Row* at(const LongRows<Row>& rows, std::int64_t time_ns) {
  const auto* const found =
      std::lower_bound(rows.begin(), rows.end(), time_ns,
                       [](const Row& row, std::int64_t t) { return row.time_ns < t; });
  return found == rows.end() || found->time_ns != time_ns ? nullptr : found;
}

}  // namespace

TrackingErrors tracking_errors(const Series& series) {
  TrackingErrors result{{LongRows<double>(series.folder), LongRows<double>(series.folder)},
                        {LongRows<double>(series.folder), LongRows<double>(series.folder)}};
  std::int64_t tracking_since = 0;
  for (const CommandRow& command : series.command) {
    if (!command.tracking) continue;
    if (tracking_since == 0) tracking_since = command.time_ns;
    if (command.time_ns - tracking_since < kSettling) continue;
    const StateRow* state = at(series.state, command.state_ns);
    if (state == nullptr) continue;
    const PlanRow* plan = at(series.plan, command.plan_ns);
    TrackingError& errors = plan == nullptr || plan->rolling ? result.task : result.approach;
    errors.time.push_back(kNs * static_cast<double>(state->time_ns - start_ns(series)));
    errors.error.push_back((state->p_WE - command.p_WE_desired).norm());
  }
  return result;
}

}  // namespace c3rt::cli
