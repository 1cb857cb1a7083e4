#pragma once
// What a caller's matrix must be.
#include <stdexcept>
#include <string>

#include <Eigen/Core>

namespace c3rt::lcs {

/// @throws std::invalid_argument if `given`, named `name`, has other sizes or a number that is not
/// finite
inline void require(const char* name, const Eigen::Ref<const Eigen::MatrixXd>& given,
                    Eigen::Index rows, Eigen::Index cols) {
  const auto shape = [](Eigen::Index r, Eigen::Index c) {
    return std::to_string(r) + " x " + std::to_string(c);
  };
  if (given.rows() != rows || given.cols() != cols)
    throw std::invalid_argument(std::string(name) + ": expected " + shape(rows, cols) + ", got " +
                                shape(given.rows(), given.cols()));
  if (!given.allFinite())
    throw std::invalid_argument(std::string(name) +
                                ": expected finite numbers, got NaN or infinity");
}

}  // namespace c3rt::lcs
