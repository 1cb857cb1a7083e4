// The search for (15) on random problems of the kinds on which it has been wrong: unstable systems,
// units far apart, forces without any cost, problems that nothing meets.
#include <array>
#include <cmath>
#include <string>

#include <catch2/catch.hpp>

#include "controller/horizon/search.hpp"
#include "tests/controller/horizon/enumeration.hpp"
#include "tests/support/property.hpp"
#include "tests/support/random.hpp"

using namespace c3rt;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using horizon::SearchStatus;

namespace {

constexpr double kGap = 1e-6;

enum class Kind { kPlain, kUnstable, kUnits, kFree, kTight, kCount };

/// Instance i; small enough to be enumerated.
class Instance {
 public:
  explicit Instance(unsigned seed) : kind(static_cast<Kind>(seed % 5)), random_(seed) {
    const bool unstable = kind == Kind::kUnstable;
    const int n_lambda = unstable ? 1 : 1 + random_.index(kind == Kind::kTight ? 2 : 3);
    const int n_x = kind == Kind::kFree ? 1 + random_.index(2) : 1 + random_.index(3);
    const int n_u = 1 + random_.index(2);
    const int pairs = kind == Kind::kTight ? 3 : kind == Kind::kFree ? 4 : 6;
    const int N = std::max(1, pairs / n_lambda);
    lcs = {random_.matrix(n_x, n_x),      random_.matrix(n_x, n_u),
           random_.matrix(n_x, n_lambda), 0.3 * random_.vector(n_x),
           random_.matrix(n_lambda, n_x), random_.matrix(n_lambda, n_lambda),
           random_.matrix(n_lambda, n_u), random_.vector(n_lambda)};
    lcs.F = (lcs.F * lcs.F.transpose() + 0.3 * random_.matrix(n_lambda, n_lambda)).eval();
    if (random_.index(2) == 0) lcs.H.setZero();
    if (unstable) lcs.A += (random_.index(2) == 0 ? 2.0 : -2.0) * MatrixXd::Identity(n_x, n_x);
    if (kind == Kind::kFree) {  // as with friction: slacks move nothing, forces work against others
      if (n_lambda > 1) lcs.D.col(1) = -lcs.D.col(0);
      if (n_lambda > 2) lcs.D.col(2).setZero();
      if (random_.index(2) == 0) lcs.F.diagonal()[0] = 0.0;
    }
    if (kind == Kind::kTight) {
      lcs.F = random_.matrix(n_lambda, n_lambda);
      if (random_.index(3) == 0) lcs.F.setZero();
    }
    const MatrixXd root = random_.matrix(n_x, n_x);
    costs.Q = MatrixXd(root * root.transpose() + 0.1 * MatrixXd::Identity(n_x, n_x));
    costs.Q_N = 2.0 * costs.Q[0];
    costs.R = MatrixXd(0.2 * MatrixXd::Identity(n_u, n_u));
    sizes = {n_x, n_lambda, n_u, N};
    x0 = random_.vector(n_x);
    x_desired = random_.matrix(n_x, N + 1);
    if (kind == Kind::kTight) {
      constraints.u_min = VectorXd::Constant(n_u, -0.5);
      if (random_.index(2) == 0) {
        constraints.x_N_min = x_desired.col(N);
        constraints.x_N_max = x_desired.col(N);
      }
    }
    if (kind == Kind::kUnits) {  // every pair, input and state in units of its own
      for (int j = 0; j < n_lambda; ++j) {
        const double force = unit(), gap = unit();
        lcs.D.col(j) *= force;
        lcs.F.col(j) *= force;
        lcs.E.row(j) *= gap;
        lcs.F.row(j) *= gap;
        lcs.H.row(j) *= gap;
        lcs.c[j] *= gap;
      }
      const double input = unit();
      lcs.B *= input;
      lcs.H *= input;
      costs.R[0] *= input * input;
      const double state = unit();  // x = state x̃
      lcs.B /= state, lcs.D /= state, lcs.d /= state, x0 /= state, x_desired /= state;
      lcs.E *= state;
      costs.Q[0] *= state * state, costs.Q_N *= state * state;
    }
  }

  horizon::Problem problem() const {
    return {sizes, {&lcs, 0}, &costs, &constraints, x_desired, x0};
  }

  /// The same with forces in other units.
  Instance scaled(double s) const {
    Instance other = *this;
    lcs::scale_forces(other.lcs, s);
    return other;
  }
  double unit() { return std::pow(10.0, random_.uniform(-4.0, 4.0)); }

  Kind kind;
  lcs::Lcs lcs;
  c3::Costs costs;
  c3::Constraints constraints;
  c3::Sizes sizes;
  VectorXd x0;
  MatrixXd x_desired;

 private:
  support::Random random_;
};

horizon::SearchResult search(const Instance& instance) {
  return horizon::search(instance.problem(), {1'000'000, kGap});
}

}  // namespace

TEST_CASE("search: what is called proven or infeasible is so, by enumeration in long double") {
  int proven = 0, infeasible = 0, undecided = 0;
  const int count = test::property_instances();
  for (int i = 0; i < count; ++i) {
    const Instance instance(static_cast<unsigned>(i));
    INFO("instance " << i);
    const horizon::SearchResult result = search(instance);
    const auto best = enumeration::optimum(instance.problem());
    INFO(describe(result) << ", enumeration " << (best ? static_cast<double>(*best) : NAN));
    switch (result.status) {
      case SearchStatus::kOptimal: {
        ++proven;
        REQUIRE(best);
        const auto optimum = static_cast<double>(*best);
        const double scale = std::max(optimum, 1e-6);
        CHECK(result.plan->objective >= optimum - 1e-7 * scale);
        CHECK(result.plan->objective <= optimum + 1.1 * kGap * scale);
        CHECK(result.lower_bound <= optimum + 1e-9 * scale);
        CHECK(horizon::residual(instance.problem(), *result.plan) <= horizon::kMet);
        break;
      }
      case SearchStatus::kInfeasible:
        ++infeasible;
        CHECK_FALSE(best);
        CHECK_FALSE(result.plan);
        break;
      default:
        ++undecided;
        if (result.plan) CHECK(result.lower_bound <= static_cast<double>(*best) * (1.0 + 1e-9));
    }
  }
  CHECK(proven + infeasible >= 0.98 * count);
  CHECK(infeasible >= count / 100);
  WARN(proven << " proven, " << infeasible << " infeasible, " << undecided << " undecided");
}

TEST_CASE("search: the units of forces do not matter") {
  for (int i = 0; i < test::property_instances(); ++i) {
    const Instance instance(static_cast<unsigned>(i));
    support::Random random(static_cast<unsigned>(i));
    const double s = std::pow(10.0, random.uniform(-6.0, 6.0));
    INFO("instance " << i << ", forces in units of " << s);
    const horizon::SearchResult one = search(instance), other = search(instance.scaled(s));
    CHECK(one.status == other.status);
    if (one.is_proven() && other.is_proven())
      CHECK(one.plan->objective == Approx(other.plan->objective).epsilon(2.2 * kGap).margin(1e-12));
  }
}

TEST_CASE("search: over a long horizon of an unstable system no feedback policy is cheaper") {
  int proven = 0;
  const int count = test::property_instances();
  for (int i = 0; i < count; ++i) {
    INFO("instance " << i);
    support::Random random(static_cast<unsigned>(i));
    const double a = (random.index(2) == 0 ? 1.0 : -1.0) * random.uniform(1.5, 4.0);
    const double b = random.uniform(0.2, 1.0), r = std::pow(10.0, random.uniform(-2.0, 1.0));
    const auto one = [](double value) { return MatrixXd::Constant(1, 1, value); };
    const lcs::Lcs system{one(a),
                          one(b),
                          one(random.uniform(-0.3, 0.3)),
                          VectorXd::Zero(1),
                          one(random.uniform()),
                          one(random.uniform(0.5, 2.0)),
                          one(0.2 * random.uniform()),
                          VectorXd::Constant(1, random.uniform(0.0, 0.3))};
    c3::Costs costs;
    costs.Q = MatrixXd(one(1.0));
    costs.R = MatrixXd(one(r));
    costs.Q_N = one(2.0);
    const c3::Constraints none;
    const int N = 12 + random.index(25);
    const double x0 = random.uniform();
    const horizon::Problem problem{{1, 1, 1, N},
                                   {&system, 0},
                                   &costs,
                                   &none,
                                   MatrixXd::Zero(1, N + 1),
                                   VectorXd::Constant(1, x0)};
    const horizon::SearchResult result = horizon::search(problem, {3000, 1e-4});
    REQUIRE(result.plan);
    proven += result.is_proven() ? 1 : 0;
    CHECK(horizon::residual(problem, *result.plan) <= horizon::kMet);
    for (const double heavier : {0.1, 1.0, 10.0}) {
      double P = 2.0, gain = 0.0;
      for (int k = 0; k < 200; ++k) {
        gain = a * b * P / (heavier * r + b * b * P);
        P = 1.0 + a * a * P - a * b * P * gain;
      }
      double x = x0, cost = 0.0;
      for (int k = 0; k < N; ++k) {
        const double u = -gain * x;
        const double gap = system.E(0, 0) * x + system.H(0, 0) * u + system.c[0];
        const double force = std::max(0.0, -gap / system.F(0, 0));
        cost += x * x + r * u * u;
        x = a * x + b * u + system.D(0, 0) * force;
      }
      cost += 2.0 * x * x;
      CHECK(result.lower_bound <= cost * (1.0 + 1e-9));
      if (result.is_proven()) CHECK(result.plan->objective <= cost * (1.0 + 1.1e-4));
    }
  }
  CHECK(proven >= 0.9 * count);
}
