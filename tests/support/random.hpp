#pragma once

#include <random>

#include <Eigen/Core>

namespace c3rt::support {

/// Matrices of independent numbers, equal for equal seeds on every machine.
class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}

  /// In [low, high).
  double uniform(double low = -1.0, double high = 1.0) {
    // not std::uniform_real_distribution, whose numbers the standard leaves open
    return low + (high - low) * static_cast<double>(engine_()) / 4294967296.0;
  }
  int index(int count) { return static_cast<int>(engine_() % static_cast<unsigned>(count)); }

  Eigen::MatrixXd matrix(Eigen::Index rows, Eigen::Index cols) {
    Eigen::MatrixXd m(rows, cols);
    for (Eigen::Index j = 0; j < cols; ++j) {
      for (Eigen::Index i = 0; i < rows; ++i) m(i, j) = uniform();
    }
    return m;
  }
  Eigen::VectorXd vector(Eigen::Index size) { return matrix(size, 1); }

 private:
  std::mt19937 engine_;
};

}  // namespace c3rt::support
