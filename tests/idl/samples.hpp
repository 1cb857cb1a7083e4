#pragma once
// Samples that every reader lets in, with nothing in them but what they must have.
#include <type_traits>

#include "idl/topics.hpp"

namespace c3rt::wire::test {

template <typename T>
T plain() {
  T sample{};
  if constexpr (std::is_same_v<T, RobotState>) sample.q_WE[0] = 1.0;
  if constexpr (std::is_same_v<T, Plan>) {
    sample.q_WE_desired[0] = 1.0;
    sample.valid_until_ns = 1'000'000'000;
  }
  if constexpr (std::is_same_v<T, BallEstimate>) sample.q_WB[0] = 1.0;
  if constexpr (std::is_same_v<T, Scene>) {
    sample.ball_count = 1;
    sample.q_WB[0][0] = 1.0;
  }
  return sample;
}

}  // namespace c3rt::wire::test
