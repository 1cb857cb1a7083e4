#include "controller/model/balls_model.hpp"
#include "controller/planner/planning_model.hpp"

namespace c3rt::planner {
namespace {

model::BallsModelParameters balls_parameters(const Parameters& parameters) {
  const model::BallModelParameters& one = parameters.model;
  model::BallsModelParameters balls{};
  balls.end_effector_mass = one.end_effector_mass;
  balls.end_effector_radius = one.end_effector_radius;
  balls.table_height = one.table_height;
  balls.friction_end_effector = one.friction_end_effector;
  balls.friction_balls = parameters.friction_balls;
  balls.balls.assign(static_cast<std::size_t>(parameters.balls), {one.ball_mass, one.ball_radius});
  return balls;
}

class SeveralBalls : public PlanningModel {
 public:
  explicit SeveralBalls(const Parameters& parameters)
      : parameters_(balls_parameters(parameters)),
        layout_{parameters.balls},
        all_(model::all_contact_pairs(parameters.balls)),
        planned_(parameters.pairs),
        x_(layout_.n_x()) {}

  int n_x() const noexcept override { return layout_.n_x(); }
  int n_c(Contacts contacts) const noexcept override {
    return static_cast<int>(pairs(contacts).size());
  }
  int v_WE() const noexcept override { return layout_.v_WE(); }

  void state(const Scene& scene, Eigen::Ref<Eigen::VectorXd> x) const override {
    x.segment<3>(model::BallsLayout::p_WE) = scene.p_WE;
    x.segment<3>(layout_.v_WE()) = scene.v_WE;
    for (int i = 0; i < layout_.balls; ++i) {
      const Ball& ball = scene.balls[static_cast<std::size_t>(i)];
      x.segment<2>(layout_.p_WB(i)) = ball.p_WB.head<2>();
      x.segment<2>(layout_.v_WB(i)) = ball.v_WB.head<2>();
    }
  }
  model::ContactSystem contact_system(const Scene& scene, Contacts contacts) const override {
    state(scene, x_);
    return model::balls_contact_system(parameters_, pairs(contacts), x_);
  }

  Eigen::VectorXd Q(const PhaseWeights& weights) const override {
    Eigen::VectorXd Q(layout_.n_x());
    Q.segment<3>(model::BallsLayout::p_WE).setConstant(weights.Q_end_effector);
    Q.segment<3>(layout_.v_WE()).setConstant(weights.Q_end_effector_velocity);
    for (int i = 0; i < layout_.balls; ++i) {
      Q.segment<2>(layout_.p_WB(i)).setConstant(weights.Q_ball_xy[static_cast<std::size_t>(i)]);
      Q.segment<2>(layout_.v_WB(i)).setConstant(weights.Q_ball_velocity);
    }
    return Q;
  }
  ContactWeights G(const PhaseWeights& weights, int contact) const override {
    const model::ContactPair& pair = planned_[static_cast<std::size_t>(contact)];
    return pair.first == model::ContactPair::kEndEffector
               ? ContactWeights{weights.G_end_effector_normal, weights.G_end_effector_tangential}
               : ContactWeights{weights.G_balls_normal, weights.G_balls_tangential};
  }

  // λ = [γ; n; t] by contacts; the end effector is the first body of its pairs, whose normal points
  // from ball to end effector
  Eigen::Vector3d force_on_end_effector(
      const Scene& scene, const Eigen::Ref<const Eigen::VectorXd>& lambda) const override {
    Eigen::Vector3d force = Eigen::Vector3d::Zero();
    const int n_c = this->n_c(Contacts::kAll);
    for (int i = 0; i < n_c; ++i) {
      const model::ContactPair& pair = all_[static_cast<std::size_t>(i)];
      if (pair.first != model::ContactPair::kEndEffector) continue;
      Eigen::Vector3d center = scene.balls[static_cast<std::size_t>(pair.second)].p_WB;
      center.z() = parameters_.table_height + parameters_.balls[0].radius;
      const Eigen::Vector3d n = (scene.p_WE - center).normalized();
      force +=
          model::contact_force(n, lambda[n_c + i], lambda.segment<kEdges>(2 * n_c + kEdges * i));
    }
    return force;
  }

 private:
  const std::vector<model::ContactPair>& pairs(Contacts contacts) const noexcept {
    return contacts == Contacts::kAll ? all_ : planned_;
  }

  model::BallsModelParameters parameters_;
  model::BallsLayout layout_;
  std::vector<model::ContactPair> all_, planned_;
  mutable Eigen::VectorXd x_;
};

}  // namespace

std::unique_ptr<PlanningModel> make_several_balls(const Parameters& parameters) {
  return std::make_unique<SeveralBalls>(parameters);
}

}  // namespace c3rt::planner
