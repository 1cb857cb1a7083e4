#include "cli/restart_policy.hpp"

#include <cmath>

namespace c3rt::cli {
namespace {

constexpr double kFirstWait = 0.2;  // before the second restart; the first one is at once [s]

}  // namespace

std::optional<double> RestartPolicy::died(double now) {
  ++deaths_;
  recent_.push_back(now);
  while (now - recent_.front() > kWindow) recent_.pop_front();
  const int count = static_cast<int>(recent_.size());
  if (count > kMost) return std::nullopt;
  return count == 1 ? now : now + kFirstWait * std::pow(2.0, count - 2);
}

}  // namespace c3rt::cli
