#pragma once
// What the scenario's `vision:` section says. Plain data; load_parameters.hpp reads it.
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "vision/tag/joint_fit.hpp"
#include "vision/tag/pose_filter.hpp"
#include "vision/track/acceleration_filter.hpp"
#include "vision/track/detect.hpp"
#include "vision/track/estimator.hpp"
#include "vision/track/fuse.hpp"

namespace c3rt::vision {

enum class SourceKind {
  kCameras,   // rendered views, circle detection, fusion
  kEmulated,  // ground truth at the exposure plus noise (paper, VII-A)
};

/// What the objects look like.
enum class ObjectColours {
  kDistinct,  // each in a colour of its own, by which it is told apart
  kSame,      // all orange: told apart by where they were
};

struct EmulatedParameters {
  double noise;              // standard deviation on x and y [m]
  double clip;               // the noise of one axis never exceeds this [m]
  double angle_noise = 0.0;  // of an orientation, about z; a sphere's does not show [rad]
  // error that stays a while (Ornstein-Uhlenbeck): standard deviation on x and y, and about z
  double drift = 0.0;        // [m]
  double angle_drift = 0.0;  // [rad]
  double drift_time = 1.0;   // after which 1/e of it is left [s]
  double delay = 0.0;        // a pose is this much older than its exposure says [s]
};

struct CameraParameters {
  std::string name;
  Eigen::Vector3d p_WC;  // [m]
  Eigen::Matrix3d R_WC;  // x right, y down, z forward in the image
  double fovy;           // vertical field of view [rad]
  int width, height;     // of the full image [px]
};

/// How far the virtual cameras stand from where the scenario says, which is what the tracker
/// believes: standard deviation along and about each axis, drawn once from the seed.
struct CalibrationError {
  double position = 0.0;  // [m]
  double angle = 0.0;     // [rad]
};

/// Of objects that the cameras know by their tags.
struct TagParameters {
  double margin;  // around where the tags of an object are expected [px]
  int region;     // longest side of the region that is read [px]
  JointFitParameters fit;
  PoseFilterParameters filter;
};

struct Parameters {
  SourceKind source;
  double rate;  // exposures per second [Hz]
  EmulatedParameters emulated;
  EstimatorParameters estimator;
  // of a sphere that is alone on the table; none: not learnt
  std::optional<AccelerationFilterParameters> acceleration_filter;
  FusionParameters fusion;
  DetectorParameters detector;
  std::optional<TagParameters> tags;  // none: spheres alone are tracked
  ObjectColours colours;
  double pixel_noise;  // standard deviation of the virtual cameras' noise [grey levels]
  CalibrationError calibration_error;
  std::vector<CameraParameters> cameras;
};

}  // namespace c3rt::vision
