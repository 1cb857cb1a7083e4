#include "vision/track/assign.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>

#include <catch2/catch.hpp>

using c3rt::vision::assign;

namespace {

double total(const Eigen::MatrixXd& cost, double unassigned, const std::vector<int>& columns) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < cost.rows(); ++i) {
    const int column = columns[static_cast<std::size_t>(i)];
    sum += column < 0 ? unassigned : cost(i, column);
  }
  return sum;
}

/// Least total over every way to line up the columns, with one "no column" for each row.
double least_total(const Eigen::MatrixXd& cost, double unassigned) {
  const auto rows = static_cast<std::size_t>(cost.rows());
  std::vector<int> order(static_cast<std::size_t>(cost.cols()) + rows);
  std::iota(order.begin(), order.end(), 0);
  double least = std::numeric_limits<double>::infinity();
  do {
    std::vector<int> columns;
    for (std::size_t i = 0; i < rows; ++i)
      columns.push_back(order[i] < static_cast<int>(cost.cols()) ? order[i] : -1);
    least = std::min(least, total(cost, unassigned, columns));
  } while (std::next_permutation(order.begin(), order.end()));
  return least;
}

}  // namespace

TEST_CASE("assign: the total is the least of all ways, and no column is given twice") {
  std::mt19937_64 engine(3);
  const auto uniform = [&] { return static_cast<double>(engine() >> 11) * 0x1p-53; };
  for (int trial = 0; trial < 60; ++trial) {
    const auto rows = static_cast<Eigen::Index>(1 + engine() % 4);
    const auto columns = static_cast<Eigen::Index>(engine() % 5);
    Eigen::MatrixXd cost(rows, columns);
    for (Eigen::Index i = 0; i < cost.size(); ++i) {
      cost(i) = uniform() < 0.2 ? std::numeric_limits<double>::infinity() : uniform();
    }
    const double unassigned = 0.6;
    const std::vector<int> result = assign(cost, unassigned);
    REQUIRE(result.size() == static_cast<std::size_t>(rows));
    REQUIRE(total(cost, unassigned, result) == Approx(least_total(cost, unassigned)));
    for (Eigen::Index j = 0; j < columns; ++j)
      REQUIRE(std::count(result.begin(), result.end(), static_cast<int>(j)) <= 1);
  }
}

TEST_CASE("assign: the nearest is not taken where that would leave another row without") {
  Eigen::MatrixXd cost(2, 2);
  cost << 0.3, 0.1,  //
      0.9, 0.2;
  CHECK(assign(cost, 0.8) == std::vector<int>{0, 1});
}

TEST_CASE("assign: a pair beyond the gate is not made") {
  Eigen::MatrixXd cost(1, 2);
  cost << 1.2, std::numeric_limits<double>::infinity();
  CHECK(assign(cost, 1.0) == std::vector<int>{-1});
  CHECK(assign(Eigen::MatrixXd(2, 0), 1.0) == std::vector<int>{-1, -1});
}
