#pragma once
#include <Eigen/Core>

namespace c3rt::cli {

/// A list of rows. @tparam Json of nlohmann
template <typename Json>
Json rows_of(const Eigen::MatrixXd& matrix) {
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    Json row = Json::array();
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) row.push_back(matrix(i, j));
    rows.push_back(row);
  }
  return rows;
}

}  // namespace c3rt::cli
