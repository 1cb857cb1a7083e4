#include "cli/table.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "cli/fields.hpp"
#include "config/text.hpp"

namespace c3rt::cli {
namespace {

constexpr double kTerminalPeriod = 0.5, kLinePeriod = 5.0;  // [s]

std::string shown(double value, int digits) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, digits) : "-";
}

int terminal_width() {
  winsize size{};
  return ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 120;
}

struct Planning {
  std::string phase = "-", status = "-", solve = "-";
};

Planning planning(const Live& live) {
  if (!live.plan) return {};
  return {
      config::printable(live.plan->phase), name_of(live.plan->status),
      live.plan->solve_time_s > 0.0 ? fmt::format("{:.2f}", live.plan->solve_time_s * 1e3) : "-"};
}

}  // namespace

std::uint64_t counter(const wire::ServiceStatus& status, const char* name) {
  for (int i = 0; i < c3rt_v2_COUNTERS; ++i) {
    if (std::strcmp(status.counter_names[i], name) == 0) return status.counters[i];
  }
  return 0;
}

std::string service_table(
    const std::array<std::optional<wire::ServiceStatus>, wire::kProcessCount>& services) {
  std::string text =
      fmt::format("  {:<10} {:<9} {:>8} {:>9} {:>13} {:>13} {:>7}  {}\n", "process", "state", "pid",
                  "rate Hz", "wake p99 ms", "step p99 ms", "missed", "says");
  for (int i = 0; i < wire::kProcessCount; ++i) {
    const auto process = static_cast<wire::Process>(i);
    if (process == c3rt_v2_PROCESS_RECORDER) continue;
    const auto& status = services[static_cast<std::size_t>(i)];
    if (!status) {
      text += fmt::format("  {:<10} {:<9}\n", wire::process_name(process), "silent");
      continue;
    }
    text += fmt::format("  {:<10} {:<9} {:>8} {:>9.1f} {:>13.3f} {:>13.3f} {:>7}  {}\n",
                        wire::process_name(process), name_of(status->state), status->pid,
                        status->rate_hz, status->wakeup_latency.p99_s * 1e3,
                        status->compute.p99_s * 1e3, counter(*status, "missed_cycles"),
                        config::printable(status->text, sizeof status->text));
  }
  for (const auto& status : services) {
    for (int i = 0; status && i < wire::refused_kinds(*status); ++i) {
      const wire::RefusedSamples& refused = status->refused[i];
      text +=
          fmt::format("  {} refused {} samples of {} ({}), the newest: {}\n",
                      wire::process_name(status->process), refused.count, refused.topic,
                      config::printable(refused.reason), config::printable(refused.latest, 300));
    }
  }
  return text;
}

LiveTable::LiveTable(const std::string& title, const std::string& unit, int goal, double duration)
    : title_(title),
      unit_(unit),
      goal_(goal),
      duration_(duration),
      terminal_(isatty(STDOUT_FILENO) == 1) {}

void LiveTable::tell_changes(const Live& live) {
  for (std::size_t i = 0; i < states_.size(); ++i) {
    const auto& status = live.services[i];
    if (!status || status->state == states_[i]) continue;
    states_[i] = status->state;
    fmt::print("[{:7.1f} s] {} is {}: {}\n", live.time, wire::process_name(status->process),
               name_of(status->state), status->text);
  }
}

void LiveTable::update(const Live& live) {
  if (!terminal_) tell_changes(live);
  if (wall_time() - drawn_at_ >= (terminal_ ? kTerminalPeriod : kLinePeriod)) draw(live);
}

void LiveTable::finish(const Live& live) { draw(live); }

void LiveTable::draw(const Live& live) {
  const double now = wall_time();
  if (drawn_at_ > 0.0 && live.steps > drawn_steps_ && drawn_steps_ > 0) {
    factor_ = static_cast<double>(live.steps - drawn_steps_) * 1e-3 / (now - drawn_at_);
  }
  drawn_at_ = now;
  drawn_steps_ = live.steps;

  const Planning plan = planning(live);
  const std::string error = shown(live.object_error * 1e3, 1);
  std::string text;
  if (terminal_) {
    text = fmt::format("{}\n", title_);
    text += fmt::format("  time {:>7.1f} s of {:g}   x {} real time\n", live.time, duration_,
                        shown(factor_, 2));
    text += fmt::format(
        "  {} {:>6.2f} of {}   object {:>5} mm from the path   phase {:<8}  plan {:<9}  solve "
        "{} ms\n",
        unit_, live.turns, goal_, error, plan.phase, plan.status, plan.solve);
    text += service_table(live.services);
    const auto lines = static_cast<int>(std::count(text.begin(), text.end(), '\n'));
    std::string screen = lines_ > 0 ? fmt::format("\x1b[{}A", lines_) : "";
    // a line that wraps would put the next drawing in the wrong place
    const int width = terminal_width();
    int column = 0;
    for (const char c : text) {
      if (c == '\n') screen += "\x1b[K";  // what the last drawing left at the end of the line
      if (c == '\n' || column < width) screen += c;
      column = c == '\n' ? 0 : column + 1;
    }
    lines_ = lines;
    text = screen;
  } else {
    std::string rates;
    std::uint64_t missed = 0;
    for (int i = 0; i < wire::kProcessCount; ++i) {
      const auto& status = live.services[static_cast<std::size_t>(i)];
      if (!status) continue;
      rates += fmt::format(" {} {:.0f}", wire::process_name(static_cast<wire::Process>(i)),
                           status->rate_hz);
      missed += counter(*status, "missed_cycles");
    }
    text = fmt::format(
        "[{:7.1f} s] {} {:.2f}  object {} mm  {}  plan {}  solve {} ms |{} Hz | missed {} | x "
        "{}\n",
        live.time, unit_, live.turns, error, plan.phase, plan.status, plan.solve, rates, missed,
        shown(factor_, 2));
  }
  std::fwrite(text.data(), 1, text.size(), stdout);
  std::fflush(stdout);
}

}  // namespace c3rt::cli
