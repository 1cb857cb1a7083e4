#pragma once

namespace c3rt::cli {

// what every command exits with
constexpr int kDone = 0;             // and the criteria are met
constexpr int kCriterionFailed = 1;  // it ran, but a criterion failed
constexpr int kUsage = 2;            // the call or the scenario is wrong
constexpr int kProcessFailed = 3;    // a process failed; it has been named
constexpr int kUndecided = 4;        // ended by a limit or by rounding before it had an answer

}  // namespace c3rt::cli
