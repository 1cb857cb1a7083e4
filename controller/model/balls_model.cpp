#include "controller/model/balls_model.hpp"

#include <stdexcept>
#include <string>

#include "controller/model/ball_model.hpp"

namespace c3rt::model {
namespace {

constexpr double kGravity = 9.81;  // [m/s²]
constexpr int kEdges = 4;

/// A body's sphere, and where its velocities stand.
struct Sphere {
  Eigen::Vector3d center;
  double radius;
  int ball;  // kEndEffector or its index
};

Sphere sphere(const BallsModelParameters& parameters, const Eigen::VectorXd& x, int body) {
  if (body == ContactPair::kEndEffector)
    return {x.segment<3>(BallsLayout::p_WE), parameters.end_effector_radius, body};
  const BallsLayout layout{static_cast<int>(parameters.balls.size())};
  const double radius = parameters.balls[static_cast<std::size_t>(body)].radius;
  Eigen::Vector3d center;
  center << x.segment<2>(layout.p_WB(body)), parameters.table_height + radius;
  return {center, radius, body};
}

/// Adds `sign` times the velocity of the body's surface in direction n from its centre.
void add_surface_velocity(const Sphere& body, const Eigen::Vector3d& n, double sign,
                          Eigen::Ref<Eigen::MatrixXd> velocity) {
  if (body.ball == ContactPair::kEndEffector) {
    velocity.leftCols<3>() += sign * Eigen::Matrix3d::Identity();
    return;
  }
  // v + ω × r n with ω = ẑ × v / r
  Eigen::Matrix<double, 3, 2> P;
  P << (1.0 + n.z()) * Eigen::Matrix2d::Identity(), -n.head<2>().transpose();
  velocity.middleCols<2>(BallsLayout{}.p_WB(body.ball)) += sign * P;
}

void check(const ContactPair& pair, std::size_t index, int balls) {
  const auto known = [balls](int body) {
    return body == ContactPair::kEndEffector || (body >= 0 && body < balls);
  };
  if (known(pair.first) && known(pair.second) && pair.first != pair.second) return;
  throw std::invalid_argument("contact pair " + std::to_string(index) +
                              ": expected two different bodies of -1 (the end effector) to " +
                              std::to_string(balls - 1) + ", got " + std::to_string(pair.first) +
                              " and " + std::to_string(pair.second));
}

}  // namespace

std::vector<ContactPair> all_contact_pairs(int balls) {
  std::vector<ContactPair> pairs;
  for (int ball = 0; ball < balls; ++ball) pairs.push_back({ContactPair::kEndEffector, ball});
  for (int first = 0; first < balls; ++first) {
    for (int second = first + 1; second < balls; ++second) pairs.push_back({first, second});
  }
  return pairs;
}

ContactSystem balls_contact_system(const BallsModelParameters& parameters,
                                   const std::vector<ContactPair>& pairs,
                                   const Eigen::VectorXd& x) {
  const BallsLayout layout{static_cast<int>(parameters.balls.size())};
  const int n_v = layout.n_v();
  if (x.size() != layout.n_x())
    throw std::invalid_argument("balls model: x: expected " + std::to_string(layout.n_x()) +
                                " numbers, got " + std::to_string(x.size()));

  ContactSystem system;
  system.q = x.head(n_v);
  system.N_q = Eigen::MatrixXd::Identity(n_v, n_v);
  system.N_q_plus = Eigen::MatrixXd::Identity(n_v, n_v);
  Eigen::VectorXd inverse_masses(n_v);
  inverse_masses.head<3>().setConstant(1.0 / parameters.end_effector_mass);
  for (int ball = 0; ball < layout.balls; ++ball)
    inverse_masses.segment<2>(layout.p_WB(ball))
        .setConstant(1.0 / (1.4 * parameters.balls[static_cast<std::size_t>(ball)].mass));
  system.M_inverse = inverse_masses.asDiagonal();
  system.J_f_q = Eigen::MatrixXd::Zero(n_v, n_v);
  system.J_f_v = Eigen::MatrixXd::Zero(n_v, n_v);
  system.J_f_u = Eigen::MatrixXd::Zero(n_v, BallsLayout::n_u);
  system.J_f_u.topRows<3>().diagonal().setConstant(1.0 / parameters.end_effector_mass);
  system.d_v = Eigen::VectorXd::Zero(n_v);
  system.d_v[2] = -kGravity;

  const auto n_c = static_cast<Eigen::Index>(pairs.size());
  system.phi.resize(n_c);
  system.mu.resize(n_c);
  system.J_n.resize(n_c, n_v);
  system.J_t.resize(n_c * kEdges, n_v);
  for (Eigen::Index i = 0; i < n_c; ++i) {
    const ContactPair& pair = pairs[static_cast<std::size_t>(i)];
    check(pair, static_cast<std::size_t>(i), layout.balls);
    const Sphere first = sphere(parameters, x, pair.first);
    const Sphere second = sphere(parameters, x, pair.second);
    const Eigen::Vector3d apart = first.center - second.center;
    const Eigen::Vector3d n = apart.normalized();
    Eigen::MatrixXd relative_velocity = Eigen::MatrixXd::Zero(3, n_v);
    add_surface_velocity(first, -n, 1.0, relative_velocity);
    add_surface_velocity(second, n, -1.0, relative_velocity);

    const bool with_end_effector =
        pair.first == ContactPair::kEndEffector || pair.second == ContactPair::kEndEffector;
    system.mu[i] = with_end_effector ? parameters.friction_end_effector : parameters.friction_balls;
    system.phi[i] = apart.norm() - first.radius - second.radius;
    system.J_n.row(i) = n.transpose() * relative_velocity;
    Eigen::Vector3d t, s;
    tangents(n, t, s);
    auto edges = system.J_t.middleRows<kEdges>(i * kEdges);
    edges.row(0) = t.transpose() * relative_velocity;
    edges.row(1) = -edges.row(0);
    edges.row(2) = s.transpose() * relative_velocity;
    edges.row(3) = -edges.row(2);
  }
  system.distance = system.phi;
  return system;
}

namespace {

Layout rolling_balls_layout(const BallsModelParameters& parameters) {
  const int balls = static_cast<int>(parameters.balls.size());
  const BallsLayout order{balls};
  Layout layout;
  layout.n_x = order.n_x();
  layout.n_v = order.n_v();
  layout.n_u = BallsLayout::n_u;
  layout.n_e = kEdges;
  layout.p_WE = BallsLayout::p_WE;
  layout.v_WE = order.v_WE();
  layout.effector_v = 0;
  layout.x.push_back({"end_effector", BallsLayout::p_WE, 3, ContactPair::kEndEffector});
  for (int i = 0; i < balls; ++i) layout.x.push_back({"ball_xy", order.p_WB(i), 2, i});
  layout.x.push_back({"end_effector_velocity", order.v_WE(), 3, ContactPair::kEndEffector});
  for (int i = 0; i < balls; ++i) layout.x.push_back({"ball_velocity", order.v_WB(i), 2, i});
  for (const ContactPair& pair : all_contact_pairs(balls)) {
    const bool end_effector = pair.first == ContactPair::kEndEffector;
    layout.contacts.push_back({end_effector ? "end_effector_ball" : "ball_ball",
                               end_effector ? "end_effector" : "balls", pair});
  }
  layout.world.effector.radius = parameters.end_effector_radius;
  layout.world.table_height = parameters.table_height;
  layout.world.body_count = balls;
  for (int i = 0; i < balls; ++i) {
    scene::Body& ball = layout.world.body(i);
    ball.name = ("ball " + std::to_string(i)).c_str();
    ball.shape = scene::Shape::sphere(parameters.balls[static_cast<std::size_t>(i)].radius);
  }
  return layout;
}

class RollingBalls final : public PlanningModel {
 public:
  explicit RollingBalls(const BallsModelParameters& parameters)
      : PlanningModel(rolling_balls_layout(parameters)), parameters_(parameters) {}

  void state(const scene::Scene& scene, Eigen::Ref<Eigen::VectorXd> x) const override {
    const BallsLayout order{static_cast<int>(parameters_.balls.size())};
    x.segment<3>(BallsLayout::p_WE) = scene.effector.p_WE;
    x.segment<3>(order.v_WE()) = scene.effector.v_WE;
    for (int i = 0; i < order.balls; ++i) {
      x.segment<2>(order.p_WB(i)) = scene.body(i).p_WB.head<2>();
      x.segment<2>(order.v_WB(i)) = scene.body(i).v_WB.head<2>();
    }
  }
  void evaluate(const scene::Scene& scene, const std::vector<int>& contacts,
                ContactSystem& system) const override {
    Eigen::VectorXd x(layout().n_x);
    state(scene, x);
    std::vector<ContactPair> pairs;
    for (const int i : contacts)
      pairs.push_back(layout().contacts[static_cast<std::size_t>(i)].bodies);
    system = balls_contact_system(parameters_, pairs, x);
  }

 private:
  BallsModelParameters parameters_;
};

}  // namespace

std::unique_ptr<PlanningModel> make_rolling_balls(const BallsModelParameters& parameters) {
  return std::make_unique<RollingBalls>(parameters);
}

ModelKind rolling_balls_kind() {
  return {"rolling_balls",
          2,
          4,
          {{"end_effector_mass_kg", 1e-4, 100},
           {"end_effector_radius_m", 1e-3, 1},
           {"ball_mass_kg", 1e-3, 100},
           {"ball_radius_m", 1e-3, 1},
           {"table_height_m", -2, 2},
           {"friction_end_effector", 0, 10},
           {"friction_balls", 0, 10}},
          [](const ModelValues& of, int bodies) {
            BallsModelParameters parameters{};
            parameters.end_effector_mass = of["end_effector_mass_kg"];
            parameters.end_effector_radius = of["end_effector_radius_m"];
            parameters.table_height = of["table_height_m"];
            parameters.friction_end_effector = of["friction_end_effector"];
            parameters.friction_balls = of["friction_balls"];
            parameters.balls.assign(static_cast<std::size_t>(bodies),
                                    {of["ball_mass_kg"], of["ball_radius_m"]});
            return make_rolling_balls(parameters);
          },
          "ball_mass_kg",
          "ball_radius_m"};
}

}  // namespace c3rt::model
