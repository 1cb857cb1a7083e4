#pragma once
// The time series of one run, as the recorder keeps them: what the report needs of each sample, in
// order of time.
#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>

#include <Eigen/Geometry>

#include "cli/report/long_rows.hpp"

namespace c3rt::cli {

constexpr int kMaxObjects = 8;
constexpr double kNone =
    std::numeric_limits<double>::quiet_NaN();  // a figure that the run does not give

inline std::array<Eigen::Vector3d, kMaxObjects> zeros() {
  std::array<Eigen::Vector3d, kMaxObjects> result;
  result.fill(Eigen::Vector3d::Zero());
  return result;
}

inline std::array<Eigen::Quaternion<double, Eigen::DontAlign>, kMaxObjects> upright() {
  std::array<Eigen::Quaternion<double, Eigen::DontAlign>, kMaxObjects> result;
  result.fill(Eigen::Quaterniond::Identity());
  return result;
}

/// Ground truth (sim/scene).
struct SceneRow {
  std::int64_t time_ns = 0;
  bool exposure = false;  // the cameras exposed at this instant
  int object_count = 0;
  std::array<Eigen::Vector3d, kMaxObjects> p_WB = zeros();  // [m]
  std::array<Eigen::Quaternion<double, Eigen::DontAlign>, kMaxObjects> q_WB = upright();
};

/// robot/state
struct StateRow {
  std::int64_t time_ns = 0;
  std::uint64_t seq = 0;
  Eigen::Vector3d p_WE = Eigen::Vector3d::Zero();  // true [m]
  bool reflex = false;
  std::uint64_t errors = 0;  // bits of plant_emulator/errors.hpp
  double success_rate = 0;   // 0..1
};

/// robot/command; stamps as in Origin, 0 = none
struct CommandRow {
  std::int64_t time_ns = 0;
  std::int64_t state_ns = 0;
  std::int64_t exposure_ns = 0;
  std::int64_t plan_ns = 0;
  bool tracking = false;  // the law follows a plan (not waiting, holding or stopped)
  Eigen::Vector3d p_WE_desired = Eigen::Vector3d::Zero();  // [m]
};

/// plan
struct PlanRow {
  std::int64_t time_ns = 0;
  std::int64_t state_ns = 0;  // the robot state that it was made from
  std::int64_t exposure_ns = 0;
  bool rolling = false;    // a phase of the strategy: the task itself, after the approach
  bool truncated = false;  // the deadline struck
  bool fallback = false;   // no solution: an older or a safe one was sent
  double solve_time = 0;   // 0 where nothing was solved [s]
};

/// object/estimate
struct EstimateRow {
  std::int64_t time_ns = 0;
  std::int64_t exposure_ns = 0;
  int object = 0;
  bool valid = false;
  int sensors_used = 0;
  Eigen::Vector3d p_measured = Eigen::Vector3d::Zero();  // before the low-pass filter [m]
  // all zero: not measured
  Eigen::Quaternion<double, Eigen::DontAlign> q_measured = Eigen::Quaterniond(0, 0, 0, 0);
};

struct Series {
  Series() = default;
  /// @param folder_of_files that take what is too long for the memory: LongRows
  explicit Series(const std::filesystem::path& folder_of_files)
      : folder(folder_of_files),
        scene(folder),
        state(folder),
        command(folder),
        plan(folder),
        estimate(folder) {}

  std::filesystem::path folder;  // empty: all of it stays in memory
  LongRows<SceneRow> scene;
  LongRows<StateRow> state;
  LongRows<CommandRow> command;
  LongRows<PlanRow> plan;
  LongRows<EstimateRow> estimate;
};

}  // namespace c3rt::cli
