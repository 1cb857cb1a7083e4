#include "vision/tag/joint_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Dense>

#include "vision/track/estimator.hpp"

namespace c3rt::vision {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNearest = 0.01;     // of what a camera sees, along its z [m]
constexpr int kSteps = 20;            // of one fit, at most
constexpr double kConverged = 1e-10;  // a step this short, metres and radians
// from where to look, then ever nearer, in units of JointFitParameters::inlier
constexpr std::array<double, 6> kRounds{16.0, 8.0, 4.0, 2.0, 1.0, 1.0};
constexpr std::size_t kMostStarts = 12;  // single views that are tried, the largest first

/// Of one corner, (δp, δθ) as in JointFit. @return false if it is not in front of the camera
bool residual(const CameraModel& camera, const Isometry3d& X_CW, const Isometry3d& X_WB,
              const Vector3d& p_B, const Vector2d& seen, Vector2d& r,
              Eigen::Matrix<double, 2, 6>* J) noexcept {
  const Vector3d turned = X_WB.linear() * p_B;
  const Vector3d p_C = X_CW * (turned + X_WB.translation());
  if (!(p_C.z() > kNearest)) return false;
  r = project(camera, p_C) - seen;
  if (J != nullptr) {
    const double z = 1.0 / p_C.z();
    Eigen::Matrix<double, 2, 3> of_point;
    of_point << camera.fx * z, 0.0, -camera.fx * p_C.x() * z * z, 0.0, camera.fy * z,
        -camera.fy * p_C.y() * z * z;
    const Eigen::Matrix<double, 2, 3> of_world = of_point * X_CW.linear();
    // a · (δθ × t) = δθ · (t × a)
    J->leftCols<3>() = of_world;
    for (int row = 0; row < 2; ++row)
      J->block<1, 3>(row, 3) = turned.cross(of_world.row(row).transpose()).transpose();
  }
  return true;
}

struct Problem {
  const std::vector<CameraModel>& cameras;
  std::vector<Isometry3d> X_CW;
  const std::vector<TagView>& views;
  std::vector<std::array<Vector3d, 4>> corners;  // by view, in B

  explicit Problem(const std::vector<CameraModel>& all, const std::vector<TagView>& seen)
      : cameras(all), views(seen) {
    for (const CameraModel& camera : all) X_CW.push_back(camera.X_WC.inverse());
    for (const TagView& view : seen) corners.push_back(tag_corners(view.tag));
  }

  /// The farthest corner of a view [px].
  double farthest(std::size_t view, const Isometry3d& X_WB) const {
    double most = 0.0;
    Vector2d r;
    const auto camera = static_cast<std::size_t>(views[view].camera);
    for (std::size_t k = 0; k < 4; ++k) {
      if (!residual(cameras[camera], X_CW[camera], X_WB, corners[view][k], views[view].seen[k], r,
                    nullptr)) {
        return kInfinity;
      }
      most = std::max(most, r.norm());
    }
    return most;
  }

  /// Σ r² of those views, and its normal equations where they are wanted; infinite behind a camera.
  double cost(const std::vector<bool>& of, const Isometry3d& X_WB, Matrix6* H, Vector6* g) const {
    double sum = 0.0;
    if (H != nullptr) {
      H->setZero();
      g->setZero();
    }
    Vector2d r;
    Eigen::Matrix<double, 2, 6> J;
    for (std::size_t i = 0; i < views.size(); ++i) {
      if (!of[i]) continue;
      const auto camera = static_cast<std::size_t>(views[i].camera);
      for (std::size_t k = 0; k < 4; ++k) {
        if (!residual(cameras[camera], X_CW[camera], X_WB, corners[i][k], views[i].seen[k], r,
                      H != nullptr ? &J : nullptr)) {
          return kInfinity;
        }
        sum += r.squaredNorm();
        if (H != nullptr) {
          *H += J.transpose() * J;
          *g += J.transpose() * r;
        }
      }
    }
    return sum;
  }
};

Isometry3d moved(const Isometry3d& X_WB, const Vector6& by) {
  Isometry3d result = X_WB;
  result.translation() += by.head<3>();
  // by way of a quaternion, so that it stays a rotation
  const Eigen::Quaterniond q(Matrix3d(X_WB.linear()));
  result.linear() = integrate_rotation(q, by.tail<3>(), 1.0).toRotationMatrix();
  return result;
}

/// From a start to the nearest minimum of the views' cost. @return the cost there
double descend(const Problem& problem, const std::vector<bool>& of, Isometry3d& X_WB) {
  Matrix6 H;
  Vector6 g;
  double cost = problem.cost(of, X_WB, &H, &g);
  double damping = 1e-6;
  for (int step = 0; step < kSteps && std::isfinite(cost); ++step) {
    Matrix6 damped = H;
    damped.diagonal() *= 1.0 + damping;
    const Vector6 by = -damped.ldlt().solve(g);
    if (!by.allFinite()) return kInfinity;
    const Isometry3d next = moved(X_WB, by);
    Matrix6 H_next;
    Vector6 g_next;
    const double cost_next = problem.cost(of, next, &H_next, &g_next);
    if (cost_next <= cost) {
      X_WB = next;
      cost = cost_next;
      H = H_next;
      g = g_next;
      damping = std::max(0.1 * damping, 1e-9);
    } else {
      damping *= 10.0;
    }
    if (by.norm() < kConverged) break;
  }
  return cost;
}

struct Candidate {
  Isometry3d X_WB = Isometry3d::Identity();
  std::vector<bool> used;
  int count = 0;
  double cost = kInfinity;

  bool better_than(const Candidate& other) const {
    return count != other.count ? count > other.count : cost < other.cost;
  }
};

Candidate settle(const Problem& problem, const Isometry3d& start, double inlier) {
  Candidate candidate;
  candidate.X_WB = start;
  candidate.used.assign(problem.views.size(), false);
  for (const double round : kRounds) {
    candidate.count = 0;
    for (std::size_t i = 0; i < problem.views.size(); ++i) {
      candidate.used[i] = problem.farthest(i, candidate.X_WB) < round * inlier;
      candidate.count += candidate.used[i] ? 1 : 0;
    }
    if (candidate.count == 0) return candidate;
    candidate.cost = descend(problem, candidate.used, candidate.X_WB);
    if (!std::isfinite(candidate.cost)) return {};
  }
  // those that the last fit pushed out
  for (std::size_t i = 0; i < problem.views.size(); ++i) {
    if (candidate.used[i] && !(problem.farthest(i, candidate.X_WB) < inlier)) {
      candidate.used[i] = false;
      --candidate.count;
    }
  }
  return candidate;
}

/// The tag's pose in the camera from its four corners: from the plane's homography, whose first two
/// columns are the tag's axes and whose third is its middle. None for corners in a line.
std::optional<Isometry3d> square_pose(const CameraModel& camera, const TagView& view) {
  const double h = 0.5 * view.tag.size;
  const std::array<Vector2d, 4> on_tag{Vector2d(-h, -h), Vector2d(h, -h), Vector2d(h, h),
                                       Vector2d(-h, h)};
  Eigen::Matrix<double, 8, 8> A = Eigen::Matrix<double, 8, 8>::Zero();
  Eigen::Matrix<double, 8, 1> b;
  for (int k = 0; k < 4; ++k) {
    const Vector2d& t = on_tag[static_cast<std::size_t>(k)];
    const Vector3d ray = unproject(camera, view.seen[static_cast<std::size_t>(k)]);
    for (int axis = 0; axis < 2; ++axis) {
      const int row = 2 * k + axis;
      A.block<1, 3>(row, 3 * axis) << t.x(), t.y(), 1.0;
      A.block<1, 2>(row, 6) = -ray[axis] * t.transpose();
      b[row] = ray[axis];
    }
  }
  const Eigen::Matrix<double, 8, 1> x = A.colPivHouseholderQr().solve(b);
  if (!x.allFinite()) return std::nullopt;
  Matrix3d M;
  M << x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7], 1.0;
  const double scale = 0.5 * (M.col(0).norm() + M.col(1).norm());
  if (!(scale > 0.0)) return std::nullopt;
  M /= scale;
  Matrix3d R;
  R << M.col(0), M.col(1), M.col(0).cross(M.col(1));
  const Eigen::JacobiSVD<Matrix3d> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Isometry3d X_CT = Isometry3d::Identity();
  X_CT.linear() = svd.matrixU() * svd.matrixV().transpose();
  X_CT.translation() = M.col(2);
  if (X_CT.linear().determinant() < 0.0) return std::nullopt;
  return X_CT;
}

/// The other tilt under which a small square looks alike: its normal mirrored at the line of sight.
Isometry3d tilted_over(const Isometry3d& X_CT) {
  const Vector3d sight = -X_CT.translation().normalized();
  const Vector3d normal = X_CT.linear().col(2);
  const Vector3d axis = sight.cross(normal);
  if (axis.norm() < 1e-9) return X_CT;
  const double angle = std::atan2(axis.norm(), sight.dot(normal));
  Isometry3d other = X_CT;
  other.linear() = Eigen::AngleAxisd(-2.0 * angle, axis.normalized()) * X_CT.linear();
  return other;
}

/// The views by the size of their squares, the largest first.
std::vector<std::size_t> by_size(const std::vector<TagView>& views) {
  std::vector<double> size;
  std::vector<std::size_t> order;
  for (const TagView& view : views) {
    order.push_back(size.size());
    const Vector2d a = view.seen[2] - view.seen[0], b = view.seen[3] - view.seen[1];
    size.push_back(std::abs(a.x() * b.y() - a.y() * b.x()));
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return size[a] > size[b]; });
  return order;
}

}  // namespace

std::array<Vector3d, 4> tag_corners(const scene::Tag& tag) noexcept {
  const double h = 0.5 * tag.size;
  const auto corner = [&](double x, double y) {
    return Vector3d(tag.p_BT + tag.R_BT * Vector3d(x, y, 0.0));
  };
  return {corner(-h, -h), corner(h, -h), corner(h, h), corner(-h, h)};
}

JointFit fit_pose(const std::vector<CameraModel>& cameras, const std::vector<TagView>& views,
                  const std::optional<Isometry3d>& expected, const JointFitParameters& parameters) {
  JointFit fit;
  fit.used.assign(views.size(), false);
  if (views.empty()) return fit;
  const Problem problem(cameras, views);
  const int all = static_cast<int>(views.size());
  const auto explains = [all](const Candidate& candidate) {
    return 4 * candidate.count >= 3 * all;
  };
  Candidate best;
  best.count = 0;
  if (expected) best = settle(problem, *expected, parameters.inlier);
  const std::vector<std::size_t> order = by_size(views);
  for (std::size_t k = 0; k < std::min(order.size(), kMostStarts) && !explains(best); ++k) {
    const TagView& view = views[order[k]];
    const CameraModel& camera = cameras[static_cast<std::size_t>(view.camera)];
    const std::optional<Isometry3d> X_CT = square_pose(camera, view);
    if (!X_CT) continue;
    Isometry3d X_BT = Isometry3d::Identity();
    X_BT.linear() = view.tag.R_BT;
    X_BT.translation() = view.tag.p_BT;
    std::vector<bool> alone(views.size(), false);
    alone[order[k]] = true;
    for (const Isometry3d& tilt : {*X_CT, tilted_over(*X_CT)}) {
      Isometry3d X_WB = camera.X_WC * tilt * X_BT.inverse();
      if (!std::isfinite(descend(problem, alone, X_WB))) continue;
      Candidate candidate = settle(problem, X_WB, parameters.inlier);
      if (candidate.better_than(best)) best = std::move(candidate);
    }
  }
  const int least = expected ? 1 : 2;
  if (best.count < least || 2 * best.count < all) return fit;
  Matrix6 H;
  Vector6 g;
  problem.cost(best.used, best.X_WB, &H, &g);
  const Eigen::LDLT<Matrix6> factors(H);
  if (!factors.isPositive() || factors.rcond() < 1e-14) return fit;
  fit.covariance =
      parameters.corner_noise * parameters.corner_noise * factors.solve(Matrix6::Identity());
  fit.found = true;
  fit.p_WB = best.X_WB.translation();
  fit.q_WB = Eigen::Quaterniond(Matrix3d(best.X_WB.linear()));
  fit.used = best.used;
  fit.views_used = best.count;
  return fit;
}

std::optional<double> seen_size(const CameraModel& camera, const TagView& view,
                                const Isometry3d& X_WB) noexcept {
  const Isometry3d X_CB = camera.X_WC.inverse() * X_WB;
  const Vector3d normal = X_CB.linear() * view.tag.R_BT.col(2);
  const Vector3d middle = X_CB * view.tag.p_BT;
  std::array<Vector3d, 4> at;
  for (std::size_t k = 0; k < 4; ++k) {
    const Vector3d ray = unproject(camera, view.seen[k]);
    const double along = normal.dot(ray);
    if (along > -1e-6) return std::nullopt;
    at[k] = normal.dot(middle) / along * ray;
  }
  double edges = 0.0;
  for (std::size_t k = 0; k < 4; ++k) edges += (at[(k + 1) % 4] - at[k]).norm();
  return 0.25 * edges;
}

}  // namespace c3rt::vision
