#pragma once
// Waits for something that another process does.
#include <chrono>
#include <thread>

namespace c3rt::cli {

/// @return false if it has not happened after twenty seconds
template <typename Condition>
bool eventually(Condition condition) {
  for (int i = 0; i < 2000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

}  // namespace c3rt::cli
