#include "controller/planner/planning_model.hpp"

namespace c3rt::planner {
namespace {

using L = model::BallLayout;

model::BallState ball_state(const Scene& scene) {
  const Ball& ball = scene.balls[0];
  return {scene.p_WE, ball.q_WB, ball.p_WB, scene.v_WE, ball.omega_WB, ball.v_WB, ball.a_WB};
}

class OneBall : public PlanningModel {
 public:
  explicit OneBall(const Parameters& parameters)
      : parameters_(parameters.model), planned_(parameters.contacts) {}

  int n_x() const noexcept override { return L::n_x; }
  int n_c(Contacts contacts) const noexcept override {
    return contacts == Contacts::kAll ? L::n_c : static_cast<int>(planned_.size());
  }
  int v_WE() const noexcept override { return L::v_WE; }

  void state(const Scene& scene, Eigen::Ref<Eigen::VectorXd> x) const override {
    x = model::to_vector(ball_state(scene));
  }
  model::ContactSystem contact_system(const Scene& scene, Contacts contacts) const override {
    return contacts == Contacts::kAll
               ? model::ball_contact_system(parameters_, ball_state(scene))
               : model::ball_contact_system(parameters_, ball_state(scene), planned_);
  }

  Eigen::VectorXd Q(const PhaseWeights& weights) const override {
    Eigen::VectorXd Q = Eigen::VectorXd::Zero(L::n_x);
    Q.segment<3>(L::p_WE).setConstant(weights.Q_end_effector);
    Q.segment<2>(L::p_WB).setConstant(weights.Q_ball_xy[0]);
    Q[L::p_WB + 2] = weights.Q_ball_z;
    Q.segment<3>(L::v_WE).setConstant(weights.Q_end_effector_velocity);
    Q.segment<3>(L::omega_WB).setConstant(weights.Q_ball_velocity);
    Q.segment<3>(L::v_WB).setConstant(weights.Q_ball_velocity);
    return Q;
  }
  ContactWeights G(const PhaseWeights& weights, int contact) const override {
    const bool arm =
        planned_[static_cast<std::size_t>(contact)] == model::BallContact::kEndEffector;
    return arm ? ContactWeights{weights.G_end_effector_normal, weights.G_end_effector_tangential}
               : ContactWeights{weights.G_table_normal, weights.G_table_tangential};
  }

  Eigen::Vector3d force_on_end_effector(
      const Scene& scene, const Eigen::Ref<const Eigen::VectorXd>& lambda) const override {
    return model::force_on_end_effector(ball_state(scene), lambda);
  }

 private:
  model::BallModelParameters parameters_;
  std::vector<model::BallContact> planned_;
};

}  // namespace

std::unique_ptr<PlanningModel> make_one_ball(const Parameters& parameters) {
  return std::make_unique<OneBall>(parameters);
}

}  // namespace c3rt::planner
