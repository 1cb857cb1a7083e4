// What crosses the border between the package and a program with other compiler flags: matrices
// that one side allocates and the other resizes, frees or reads, fixed-size members, virtual calls,
// exceptions. Prints numbers of the library alone, of which every program has to print the same:
// first u_0 [N] of the cart-pole between soft walls with the exact projection.
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "controller/c3/solver.hpp"
#include "controller/example/closed_loop.hpp"
#include "controller/horizon/search.hpp"
#include "controller/lcs/riccati.hpp"
#include "controller/model/ball_model.hpp"
#include "controller/model/cart_pole.hpp"

namespace {

using namespace c3rt;
using Eigen::MatrixXd;
using Eigen::VectorXd;

void show(const Eigen::Ref<const MatrixXd>& numbers) {
  for (Eigen::Index j = 0; j < numbers.cols(); ++j) {
    for (Eigen::Index i = 0; i < numbers.rows(); ++i) std::printf("%.17g\n", numbers(i, j));
  }
}

void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "%s\n", what);
  std::exit(1);
}

/// Reads the library's memory as this program's vector unit does.
bool is_readable(const MatrixXd& matrix) {
  const MatrixXd doubled = 2.0 * matrix, product = matrix * doubled.transpose();
  return doubled.allFinite() && product.allFinite() && (doubled - matrix).isApprox(matrix) &&
         MatrixXd(matrix).size() == matrix.size();
}

class Still final : public example::Plant {
 public:
  void reset(const VectorXd& x) override { x_ = x; }
  bool step(const VectorXd&, VectorXd& x, VectorXd& lambda) override {
    x = x_;
    lambda = VectorXd::Zero(2);
    return true;
  }

 private:
  VectorXd x_;
};

}  // namespace

int main() {
  lcs::Lcs lcs = model::cart_pole(model::CartPoleParameters::simulated(), 0.01);
  const c3::Sizes sizes{4, 2, 1, 10};  // n_x, n_lambda, n_u, N

  c3::Costs costs;
  const MatrixXd Q = Eigen::Vector4d(10.0, 3.0, 1.0, 1.0).asDiagonal();
  const MatrixXd R = MatrixXd::Identity(1, 1);
  costs.Q = std::vector<MatrixXd>(10, Q);  // copied here, and again in the library
  costs.R = R;
  costs.Q_N = lcs::riccati(lcs.A, lcs.B, Q, R);
  costs.G = MatrixXd::Identity(sizes.n_z(), sizes.n_z());
  costs.U = MatrixXd::Identity(sizes.n_z(), sizes.n_z());
  sizes.x(costs.U.diagonal()).setConstant(1000.0);

  c3::Settings settings{};
  settings.admm_iterations = 10;
  settings.rho = 0.1;
  settings.rho_scale = 2.0;
  settings.qp = c3::QpBackend::kDirect;
  settings.projection = c3::ProjectionKind::kMiqp;
  settings.max_nodes = 1000;

  c3::Solver solver(sizes, settings);
  solver.set_costs(costs);
  const Eigen::Vector4d x0(0.1, -0.3, 0.0, 0.0);
  c3::Solution solution = solver.solve(lcs, x0, MatrixXd::Zero(4, sizes.N + 1));
  require(solution.status == c3::SolveStatus::kOk, "not solved");
  show(solution.u_0());
  show(solution.z);
  require(is_readable(solution.z) && is_readable(costs.Q_N) && is_readable(lcs.A), "not readable");

  // allocated here, resized there, and the other way round
  c3::Start start{MatrixXd::Ones(1, 1), MatrixXd::Ones(3, 3)};
  c3::shift(solution, settings.rho, start);
  require(start.delta.cols() == sizes.N && is_readable(start.w), "not shifted");
  solution.z.conservativeResize(2, 2);
  solution.delta.resize(50, 50);
  solution = solver.solve(lcs, x0, MatrixXd::Zero(4, sizes.N + 1), {}, &start);
  show(solution.delta);
  lcs::scale_forces(lcs, lcs::force_scale(lcs));
  lcs.d.conservativeResize(40);
  lcs.d.conservativeResize(4);
  show(lcs.D);

  // OSQP and constraints
  c3::Settings bounded = settings;
  bounded.osqp = {20000, 1e-8, 0.1, 50, true};
  for (const c3::QpBackend qp : {c3::QpBackend::kInteriorPoint, c3::QpBackend::kOsqp}) {
    bounded.qp = qp;
    c3::Constraints constraints;
    constraints.u_max = VectorXd::Constant(1, 0.5);
    c3::Solver other(sizes, bounded);
    other.set_costs(costs, constraints);
    const c3::Solution& answer = other.solve(lcs, x0, MatrixXd::Zero(4, sizes.N + 1));
    require(answer.status == c3::SolveStatus::kOk, "bounds: not solved");
    show(answer.u_0());
  }

  // made there, destroyed here
  const std::unique_ptr<c3::Projection> projection = c3::make_lcp_projection(sizes);
  projection->set_weights(costs);
  projection->start(lcs);
  VectorXd delta(sizes.n_z());
  require(projection->project(VectorXd::Ones(sizes.n_z()), delta, {}).status ==
              c3::ProjectionStatus::kSolved,
          "not projected");
  show(delta);
  const c3::Sizes three{4, 2, 1, 3};
  const c3::Constraints none;
  c3::Costs one = costs;
  one.Q = Q;
  const horizon::SearchResult found = horizon::search(
      {three, {&lcs, 0}, &one, &none, MatrixXd::Zero(4, 4), x0}, {}, std::nullopt, {});
  require(found.plan.has_value(), "no plan");
  show(found.plan->x);

  // fixed-size members
  std::vector<scene::Scene> scenes(3);
  for (scene::Scene& scene : scenes) {
    scene::Body& ball = scene.body(0);
    scene.effector.p_WE = {0.1, 0.2, 0.3};
    ball.q_WB = Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5);
    ball.p_WB = {0.4, 0.5, 0.6};
    scene.effector.v_WE = {1.0, 2.0, 3.0};
    ball.omega_WB = {4.0, 5.0, 6.0};
    ball.v_WB = {7.0, 8.0, 9.0};
    ball.a_WB = Eigen::Vector2d(10.0, 11.0);
    show(model::ball_state(scene));
  }
  const std::unique_ptr<model::PlanningModel> rolling =
      model::make_rolling_ball({0.01, 0.0195, 0.132, 0.0315, 0.0, 1.0, 1.0});
  const model::ContactSystem contacts = rolling->contact_system(scenes[0], {0, 1});
  show(contacts.J_t);
  show(model::force_on_end_effector(rolling->layout(), contacts, VectorXd::Ones(12)));
  Still still;
  example::Plant& plant = still;
  plant.reset(x0);

  try {
    costs.R = MatrixXd(-R);
    solver.set_costs(costs);
    require(false, "not refused");
  } catch (const std::invalid_argument& error) {
    std::printf("%s\n", error.what());
  }
  return 0;
}
