#pragma once
// When a process that has died is started again.
#include <deque>
#include <optional>

namespace c3rt::cli {

/// At once, then after waits that double, and no more where it dies too often: what fails every
/// time would only shake the robot. Times in seconds, of any clock that does not go back.
class RestartPolicy {
 public:
  static constexpr int kMost = 5;          // deaths within the window that are forgiven
  static constexpr double kWindow = 30.0;  // [s]

  /// @return when to start it again; nothing: it is given up
  std::optional<double> died(double now);
  int deaths() const { return deaths_; }  // in all

 private:
  std::deque<double> recent_;
  int deaths_ = 0;
};

}  // namespace c3rt::cli
