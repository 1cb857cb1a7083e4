#pragma once
// Which detection belongs to which ball: one assignment over all of them.
#include <vector>

#include <Eigen/Core>

namespace c3rt::vision {

/// Every row gets at most one column and every column at most one row, so that the sum of the costs
/// is least; a row without a column costs `unassigned`, so a pair that costs more is never made.
/// Exact, by enumeration with bounds: meant for a handful of rows and columns.
/// @param cost (rows × columns), not negative; infinity forbids a pair
/// @return by row: the column, or -1
std::vector<int> assign(const Eigen::MatrixXd& cost, double unassigned);

}  // namespace c3rt::vision
