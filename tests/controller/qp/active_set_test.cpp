#include "controller/qp/active_set.hpp"

#include <limits>
#include <string>

#include <catch2/catch.hpp>

namespace {

using namespace c3rt::qp;
using Eigen::VectorXd;
using Bound = ActiveSet::Bound;

constexpr int kStages = 20;
constexpr double kNone = std::numeric_limits<double>::infinity();

/// One state, of which x_1 … x_N ≤ 0; row k − 1 belongs to stage k.
struct Wall {
  Wall() : rows({1, 1, 1, kStages}), active(rows) {
    Constraints constraints;
    constraints.x_max = VectorXd::Zero(1);
    constraints.x_N_max = VectorXd::Zero(1);
    rows.set(constraints);
    active.prepare();
    active.deactivate_all();
  }
  void activate(int first, int last) {
    for (int i = first; i <= last; ++i) active.set(i, Bound::kUpper);
  }
  ActiveSet::Corrections correct() { return active.correct(value, multiplier, inverse_hessian); }
  /// '.' inactive, 'U' active, of rows 0 … N − 1.
  std::string active_rows() const {
    std::string all;
    for (int i = 0; i < kStages; ++i) all += active[i] == Bound::kUpper ? 'U' : '.';
    return all;
  }

  QpRows rows;
  ActiveSet active;
  VectorXd value = VectorXd::Constant(kStages, -1.0), multiplier = VectorXd::Zero(kStages),
           inverse_hessian = VectorXd::Ones(kStages);
};

}  // namespace

TEST_CASE("active set: of a violated run the largest violation alone is activated") {
  Wall wall;
  REQUIRE(wall.rows.count() == kStages);
  for (int i = 5; i <= 11; ++i) wall.value[i] = 1.0 - 0.1 * std::abs(i - 8);
  for (int i = 15; i <= 17; ++i) wall.value[i] = 0.01 * i;
  CHECK(wall.correct().violated == 10);
  CHECK(wall.active_rows() == "........U........U..");
}

TEST_CASE("active set: between active rows and the largest violation beside them all become so") {
  Wall wall;
  wall.activate(2, 7);
  wall.multiplier.segment(2, 6).setConstant(-1.0);
  wall.value.segment(2, 6).setZero();
  SECTION("behind them") {
    wall.value.segment(8, 5) << 1.0, 2.0, 2.5, 2.2, 1.0;
    CHECK(wall.correct().violated == 5);
    CHECK(wall.active_rows() == "..UUUUUUUUU.........");
  }
  SECTION("before them") {
    wall.value.head(2) << 2.0, 1.0;
    CHECK(wall.correct().violated == 2);
    CHECK(wall.active_rows() == "UUUUUUUU............");
  }
  SECTION("not beside them") {
    wall.value.segment(9, 4) << 2.0, 2.5, 2.2, 1.0;
    CHECK(wall.correct().violated == 4);
    CHECK(wall.active_rows() == "..UUUUUU..U.........");
  }
}

TEST_CASE("active set: a gap between active rows is closed at once") {
  Wall wall;
  wall.activate(3, 6);
  wall.activate(10, 13);
  wall.multiplier.setConstant(-1.0);
  wall.value.segment(3, 11) << 0, 0, 0, 0, 0.1, 0.2, 0.1, 0, 0, 0, 0;
  CHECK(wall.correct().violated == 3);
  CHECK(wall.active_rows() == "...UUUUUUUUUUU......");
}

TEST_CASE("active set: every row whose multiplier has the wrong sign is deactivated") {
  Wall wall;
  wall.activate(3, 12);
  wall.value.segment(3, 10).setZero();
  wall.multiplier.segment(3, 10).setConstant(-1.0);
  SECTION("none") {
    CHECK(wall.correct().all() == 0);
    CHECK(wall.active_rows() == "...UUUUUUUUUU.......");
  }
  SECTION("some") {
    wall.multiplier[5] = 0.2;
    wall.multiplier[12] = 1e9;
    CHECK(wall.correct().wrong_sign == 2);
    CHECK(wall.active_rows() == "...UU.UUUUUU........");
  }
}

TEST_CASE("active set: an equality is never deactivated") {
  const Sizes sizes{1, 1, 1, 3};
  QpRows rows(sizes);
  Constraints constraints;
  constraints.x_N_min = constraints.x_N_max = VectorXd::Zero(1);
  rows.set(constraints);
  ActiveSet active(rows);
  active.prepare();
  active.deactivate_all();
  REQUIRE(rows.count() == 1);
  for (const double multiplier : {-1e6, 1e6}) {
    const auto made =
        active.correct(VectorXd::Zero(1), VectorXd::Constant(1, multiplier), VectorXd::Ones(1));
    CHECK(made.all() == 0);
    CHECK(active[0] == Bound::kEquality);
  }
}
