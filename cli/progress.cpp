#include "cli/progress.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <utility>

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

namespace c3rt::cli {
namespace {

constexpr double kQuiet = 1.0, kTerminalPeriod = 0.2, kLinePeriod = 10.0;  // [s]
constexpr int kBar = 12;

std::size_t terminal_width() {
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

/// "3 min 20 s"
std::string shown(double seconds) {
  const long whole = std::lround(seconds);
  return whole < 60 ? fmt::format("{} s", whole)
                    : fmt::format("{} min {} s", whole / 60, whole % 60);
}

}  // namespace

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double processor_seconds_now() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

Progress::Progress(std::string title)
    : title_(std::move(title)),
      terminal_(isatty(STDERR_FILENO) == 1),
      started_(seconds_now()),
      drawn_at_(started_ + kQuiet - (terminal_ ? kTerminalPeriod : kLinePeriod)) {
  if (!terminal_) drawn_at_ = started_;
}

Progress::~Progress() {
  if (terminal_ && drawn_) fmt::print(stderr, "\r\x1b[K");
}

void Progress::say(const std::string& line) {
  if (terminal_ && drawn_) fmt::print(stderr, "\r\x1b[K");
  fmt::print(stderr, "{}\n", line);
}

bool Progress::is_time() {
  const double now = seconds_now();
  if (now - drawn_at_ < (terminal_ ? kTerminalPeriod : kLinePeriod)) return false;
  drawn_at_ = now;
  return true;
}

void Progress::draw(const std::string& line) {
  if (terminal_) {
    drawn_ = true;
    fmt::print(stderr, "\r{}\x1b[K", line.substr(0, terminal_width() - 1));
  } else {
    fmt::print(stderr, "{}\n", line);
  }
  std::fflush(stderr);
}

void Progress::update(double share, const std::string& text) {
  if (!is_time()) return;
  share = std::clamp(share, 0.0, 1.0);
  const double passed = drawn_at_ - started_;
  const std::string left =
      share > 0.01 ? ", " + shown(passed / share - passed) + " left" : std::string();
  std::string line =
      fmt::format("{}  {:3.0f} %  {} ({}{})", title_, 100.0 * share, text, shown(passed), left);
  if (terminal_) {
    const int filled = static_cast<int>(share * kBar);
    line = fmt::format("[{}{}] ", std::string(static_cast<std::size_t>(filled), '#'),
                       std::string(static_cast<std::size_t>(kBar - filled), '.')) +
           line;
  }
  draw(line);
}

void Progress::update(const std::string& text) {
  if (is_time()) draw(fmt::format("{}  {} ({})", title_, text, shown(drawn_at_ - started_)));
}

}  // namespace c3rt::cli
