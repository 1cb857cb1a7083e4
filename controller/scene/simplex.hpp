#pragma once
// The simplex of Gilbert, Johnson and Keerthi.
#include <array>
#include <limits>

#include <Eigen/Core>
#include <Eigen/QR>

namespace c3rt::scene {

/// The corners of a point, edge, triangle or tetrahedron, and how much of each makes the point that
/// is nearest to the origin.
struct Simplex {
  std::array<Eigen::Vector3d, 4> corners;
  std::array<int, 4> tags{};  // what they are corners of, for who asks
  std::array<double, 4> weights{};
  int size = 0;
  Simplex() { corners.fill(Eigen::Vector3d::Zero()); }

  void add(const Eigen::Vector3d& corner, int tag = 0) noexcept {
    corners[static_cast<std::size_t>(size)] = corner;
    tags[static_cast<std::size_t>(size)] = tag;
    weights[static_cast<std::size_t>(size++)] = 1.0;
  }
};

/// The point of a simplex that is nearest to the origin, by trying every subset of its corners.
/// Those that are not needed for it are left out.
inline Eigen::Vector3d reduce(Simplex& simplex) noexcept {
  double best = std::numeric_limits<double>::infinity();
  Eigen::Vector3d point = simplex.corners[0];
  Simplex needed;
  for (unsigned subset = 1; subset < (1U << simplex.size); ++subset) {
    Simplex of;
    for (int i = 0; i < simplex.size; ++i) {
      const auto at = static_cast<std::size_t>(i);
      if ((subset >> i & 1U) != 0) of.add(simplex.corners[at], simplex.tags[at]);
    }
    Eigen::Vector3d candidate = of.corners[0];
    if (of.size > 1) {
      // of its plane: 0 = Aᵀ (a_0 + A t), in the simplex where every weight is positive
      Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3> A(3, of.size - 1);
      for (int i = 1; i < of.size; ++i)
        A.col(i - 1) = of.corners[static_cast<std::size_t>(i)] - of.corners[0];
      const Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1> t =
          A.colPivHouseholderQr().solve(-of.corners[0]);
      if (t.minCoeff() < 0.0 || t.sum() > 1.0) continue;
      candidate += A * t;
      of.weights[0] = 1.0 - t.sum();
      for (int i = 1; i < of.size; ++i) of.weights[static_cast<std::size_t>(i)] = t[i - 1];
    }
    if (candidate.squaredNorm() < best) {
      best = candidate.squaredNorm();
      point = candidate;
      needed = of;
    }
  }
  simplex = needed;
  return point;
}

}  // namespace c3rt::scene
