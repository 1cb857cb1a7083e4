#include "controller/lcs/dictionary.hpp"

#include <vector>

#include <Eigen/Core>
#include <catch2/catch.hpp>

#include "tests/support/linear_algebra.hpp"
#include "tests/support/random.hpp"

using namespace c3rt;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using lcs::DoubleDouble;

namespace {

double number(double a) { return a; }
double number(DoubleDouble a) { return a.high; }

// a ring: no principal block but the whole is regular
MatrixXd ring(int n) {
  MatrixXd F = MatrixXd::Zero(n, n);
  for (int i = 0; i < n; ++i) F(i, (i + 1) % n) = 1.0 + i;
  return F;
}

}  // namespace

TEMPLATE_TEST_CASE("dictionary: λ that were exchanged solve their rows", "", double, DoubleDouble) {
  support::Random random(1);
  for (int trial = 0; trial < 100; ++trial) {
    const int n = 1 + random.index(8);
    const MatrixXd F = random.matrix(n, n);
    const VectorXd q = random.vector(n), ones = VectorXd::Ones(n);
    std::vector<char> wanted(static_cast<std::size_t>(n));
    std::vector<int> chosen;
    for (int i = 0; i < n; ++i) {
      wanted[static_cast<std::size_t>(i)] = random.index(2) == 1;
      if (wanted[static_cast<std::size_t>(i)]) chosen.push_back(i);
    }
    lcs::Dictionary<TestType> dictionary(n);
    dictionary.load(F, q, ones, ones, 0.0);
    REQUIRE(dictionary.exchange(wanted, 1e-11));
    VectorXd lambda = VectorXd::Zero(n);
    if (!chosen.empty()) {
      const VectorXd forces = support::solve(F(chosen, chosen), -q(chosen)).value();
      for (std::size_t i = 0; i < chosen.size(); ++i)
        lambda[chosen[i]] = forces[static_cast<Eigen::Index>(i)];
    }
    const VectorXd y = F * lambda + q;
    for (int i = 0; i < n; ++i) {
      CHECK(dictionary.is_basic(n + i) == bool(wanted[static_cast<std::size_t>(i)]));
      CHECK(dictionary.is_basic(i) != dictionary.is_basic(n + i));
      CHECK(number(dictionary.value(n + i)) == Approx(lambda[i]).epsilon(1e-6).margin(1e-8));
      if (dictionary.is_basic(i))
        CHECK(number(dictionary.value(i)) == Approx(y[i]).epsilon(1e-6).margin(1e-8));
    }
  }
}

TEST_CASE("dictionary: another right side in the same basis is as if it had been there at first") {
  support::Random random(2);
  const int n = 6;
  const MatrixXd F = random.matrix(n, n);
  const VectorXd ones = VectorXd::Ones(n), q = random.vector(n);
  const std::vector<char> wanted{1, 0, 1, 1, 0, 0};
  lcs::Dictionary<DoubleDouble> first(n), other(n);
  first.load(F, q, ones, ones, 0.0);
  other.load(F, random.vector(n), ones, ones, 0.0);
  REQUIRE(first.exchange(wanted, 1e-11));
  REQUIRE(other.exchange(wanted, 1e-11));
  std::vector<DoubleDouble> right_side;
  for (const double value : q) right_side.push_back({value});
  other.set_right_side(right_side);
  for (int i = 0; i < 2 * n; ++i) CHECK(other.value(i).high == Approx(first.value(i).high));
}

TEST_CASE("dictionary: a block without a regular part is exchanged as a whole, or not at all") {
  for (const int n : {2, 3, 6}) {
    const VectorXd ones = VectorXd::Ones(n);
    lcs::Dictionary<DoubleDouble> dictionary(n);
    dictionary.load(ring(n), -ones, ones, ones, 0.0);
    CHECK(dictionary.exchange(std::vector<char>(static_cast<std::size_t>(n), 1), 1e-11));
    for (int i = 0; i < n; ++i) CHECK(dictionary.is_basic(n + i));

    MatrixXd singular = ring(n);
    singular.row(0).setZero();
    dictionary.load(singular, -ones, ones, ones, 0.0);
    CHECK_FALSE(dictionary.exchange(std::vector<char>(static_cast<std::size_t>(n), 1), 1e-11));
    // what could not be exchanged is complementary still
    for (int i = 0; i < n; ++i) CHECK(dictionary.is_basic(i) != dictionary.is_basic(n + i));
  }
}

TEST_CASE("dictionary: Lemke's method from a basis that is not far off needs few pivots") {
  support::Random random(3);
  const int n = 12;
  const MatrixXd half = random.matrix(n, n);
  const MatrixXd F = half * half.transpose() + 0.1 * MatrixXd::Identity(n, n);
  const VectorXd q = random.vector(n), ones = VectorXd::Ones(n);
  using End = lcs::Dictionary<DoubleDouble>::End;
  lcs::Dictionary<DoubleDouble> dictionary(n);
  dictionary.load(F, q, ones, ones, 0.0);
  REQUIRE(dictionary.cover(300, 1e-11) == End::kSolved);
  const int from_nothing = dictionary.pivots();
  std::vector<DoubleDouble> near;
  for (const double value : q) near.push_back({value + 1e-3 * random.uniform()});
  dictionary.set_right_side(near);
  REQUIRE(dictionary.cover(300, 1e-11) == End::kSolved);
  CHECK(dictionary.pivots() - from_nothing < from_nothing / 2);
  CHECK(dictionary.cover(300, 1e-11) == End::kSolved);  // solved already
}
