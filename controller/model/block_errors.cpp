#include "controller/model/block_errors.hpp"

#include <algorithm>

#include <Eigen/Geometry>

namespace c3rt::model {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// x⁺ and η.
struct Outcome {
  VectorXd x, eta;
};

/// v⁺ and η where contacts push with λ.
struct Pushed {
  VectorXd v, eta;
};

Pushed push(const ContactSystem& system, ContactModel contact_model, const VectorXd& v,
            const VectorXd& u, const VectorXd& lambda, double dt) {
  const Eigen::Index n_c = system.n_c(), n_e = system.n_e();
  const VectorXd f = system.J_f_q * system.q + system.J_f_v * v + system.J_f_u * u + system.d_v;
  Pushed after{v + dt * f, VectorXd(lambda.size())};
  if (contact_model == ContactModel::kAnitescu) {
    const Eigen::Index rows = std::max<Eigen::Index>(1, n_e);
    MatrixXd J_c(lambda.size(), v.size());
    for (Eigen::Index row = 0; row < lambda.size(); ++row) {
      J_c.row(row) = system.J_n.row(row / rows);
      if (n_e > 0) J_c.row(row) += system.mu[row / rows] * system.J_t.row(row);
    }
    after.v += system.M_inverse * J_c.transpose() * lambda;
    after.eta = J_c * after.v;
    for (Eigen::Index row = 0; row < lambda.size(); ++row)
      after.eta[row] += system.phi[row / rows] / dt;
    return after;
  }
  const auto normal = lambda.segment(n_c, n_c);
  const auto edges = lambda.tail(n_c * n_e);
  after.v +=
      dt * system.M_inverse * (system.J_n.transpose() * normal + system.J_t.transpose() * edges);
  for (Eigen::Index i = 0; i < n_c; ++i) {
    after.eta[i] = system.mu[i] * normal[i] - edges.segment(i * n_e, n_e).sum();
    after.eta.segment(2 * n_c + i * n_e, n_e).setConstant(lambda[i]);
  }
  after.eta.segment(n_c, n_c) = system.phi + dt * system.J_n * after.v;
  after.eta.tail(n_c * n_e) += system.J_t * after.v;
  return after;
}

class SceneStep {
 public:
  SceneStep(const PlanningModel& model, ContactModel contact_model, const scene::Scene& scene,
            const std::vector<int>& contacts, double dt)
      : model_(model), contact_model_(contact_model), scene_(scene), contacts_(contacts), dt_(dt) {}

  /// From the scene moved by δx = [δq; δv].
  Outcome operator()(const VectorXd& dx, const VectorXd& u, const VectorXd& lambda) const {
    const Eigen::Index n_v = model_.layout().n_v;
    scene::Scene from = moved(scene_, dx.head(n_v), 1.0);
    add_velocities(dx.tail(n_v), from);
    VectorXd v(n_v);
    v.head<3>() = from.effector.v_WE;
    for (int i = 0; i < from.body_count; ++i)
      v.segment<6>(3 + 6 * i) << from.body(i).v_WB, from.body(i).omega_WB;
    const Pushed after =
        push(model_.contact_system(from, contacts_), contact_model_, v, u, lambda, dt_);
    scene::Scene to = moved(from, after.v, dt_);
    add_velocities(after.v - v, to);
    Outcome outcome{VectorXd(model_.layout().n_x), after.eta};
    model_.state_about(to, scene_, outcome.x);
    return outcome;
  }

 private:
  static void add_velocities(const VectorXd& dv, scene::Scene& scene) {
    scene.effector.v_WE += dv.head<3>();
    for (int i = 0; i < scene.body_count; ++i) {
      scene.body(i).v_WB += dv.segment<3>(3 + 6 * i);
      scene.body(i).omega_WB += dv.segment<3>(6 + 6 * i);
    }
  }

  const PlanningModel& model_;
  ContactModel contact_model_;
  const scene::Scene& scene_;
  const std::vector<int>& contacts_;
  double dt_;
};

double relative(const MatrixXd& block, const MatrixXd& truth) {
  if (block.size() == 0) return 0.0;
  const double largest = truth.cwiseAbs().maxCoeff();
  return (block - truth).cwiseAbs().maxCoeff() / (largest > 0.0 ? largest : 1.0);
}

template <typename Step>
BlockErrors errors(const lcs::Lcs& lcs, const VectorXd& x0, const Step& step) {
  constexpr double kDifference = 1e-6;
  const Eigen::Index n_x = lcs.A.rows(), n_u = lcs.B.cols(), n_lambda = lcs.F.rows();
  const VectorXd no_dx = VectorXd::Zero(n_x), no_u = VectorXd::Zero(n_u),
                 no_lambda = VectorXd::Zero(n_lambda);
  const auto difference = [&](Eigen::Index count, MatrixXd& of_x, MatrixXd& of_eta,
                              const auto& at) {
    of_x.resize(n_x, count);
    of_eta.resize(n_lambda, count);
    for (Eigen::Index i = 0; i < count; ++i) {
      const VectorXd by = kDifference * VectorXd::Unit(count, i);
      const Outcome after = at(by), before = at(-by);
      of_x.col(i) = (after.x - before.x) / (2.0 * kDifference);
      of_eta.col(i) = (after.eta - before.eta) / (2.0 * kDifference);
    }
  };
  MatrixXd A, B, D, E, F, H;
  difference(n_x, A, E, [&](const VectorXd& by) { return step(by, no_u, no_lambda); });
  difference(n_u, B, H, [&](const VectorXd& by) { return step(no_dx, by, no_lambda); });
  difference(n_lambda, D, F, [&](const VectorXd& by) { return step(no_dx, no_u, by); });
  const Outcome here = step(no_dx, no_u, no_lambda);
  return {relative(lcs.A, A), relative(lcs.B, B),
          relative(lcs.D, D), (lcs.A * x0 + lcs.d - here.x).cwiseAbs().maxCoeff(),
          relative(lcs.E, E), relative(lcs.F, F),
          relative(lcs.H, H), (lcs.E * x0 + lcs.c - here.eta).cwiseAbs().maxCoeff()};
}

}  // namespace

scene::Scene moved(const scene::Scene& scene, const VectorXd& v, double time) {
  scene::Scene result = scene;
  result.effector.p_WE += time * v.head<3>();
  for (int i = 0; i < scene.body_count; ++i) {
    scene::Body& body = result.body(i);
    body.p_WB += time * v.segment<3>(3 + 6 * i);
    const Vector3d turn = time * v.segment<3>(6 + 6 * i);
    const Eigen::Quaterniond q_WB = body.q_WB;
    if (turn.norm() > 0.0)
      body.q_WB = Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.normalized())) * q_WB;
  }
  return result;
}

BlockErrors block_errors(const PlanningModel& model, ContactModel contact_model,
                         const scene::Scene& scene, const std::vector<int>& contacts, double dt) {
  VectorXd x0(model.layout().n_x);
  model.state(scene, x0);
  return errors(to_lcs(contact_model, model.contact_system(scene, contacts), dt), x0,
                SceneStep(model, contact_model, scene, contacts, dt));
}

BlockErrors block_errors(const MechanismModel& model, const VectorXd& x, double dt) {
  const Eigen::Index n_v = model.mechanism().n_v();
  const auto step = [&](const VectorXd& dx, const VectorXd& u, const VectorXd& lambda) {
    const VectorXd from = x + dx;
    ContactSystem system;
    model.evaluate(from, system);
    const Pushed after = push(system, model.contact_model(), from.tail(n_v), u, lambda, dt);
    VectorXd q = from.head(n_v);
    scene::move(model.mechanism().coordinates(), after.v, dt, q);
    Outcome outcome{VectorXd(2 * n_v), after.eta};
    outcome.x << q, after.v;
    return outcome;
  };
  return errors(model.planning_system(x, dt), x, step);
}

}  // namespace c3rt::model
