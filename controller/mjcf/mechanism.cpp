#include "controller/mjcf/mechanism.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "controller/base/words.hpp"
#include "controller/mjcf/coordinates.hpp"
#include "controller/mjcf/loaded.hpp"

namespace c3rt::mjcf {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Kind = scene::Coordinate::Kind;

class MujocoMechanism final : public scene::Mechanism {
 public:
  explicit MujocoMechanism(const std::string& file)
      : loaded_(file), model_(loaded_.model()), data_(loaded_.data()) {
    refuse();
    go_home();
    read_bodies();
    read_surfaces();
    name_coordinates();
    read_motors();
    drop_constraints();
    file_ = file;
    const int n_v = model_->nv;
    M_.resize(n_v, n_v);
    T_.setIdentity(n_v, n_v);
    inertia_.resize(n_v, n_v);
    jacobian_.resize(3, n_v);
    q_ = v_ = before_ = after_ = VectorXd::Zero(n_v);
    factor_ = Eigen::LLT<MatrixXd>(MatrixXd::Identity(n_v, n_v));
  }

  std::vector<std::string> take_notes() { return std::move(notes_); }

  void evaluate(const Eigen::Ref<const VectorXd>& q, const Eigen::Ref<const VectorXd>& v,
                scene::SmoothMotion& motion) override {
    // f is of second order in v but for drag: any difference is exact
    constexpr double kOfPosition = 1e-5, kOfVelocity = 1e-3;
    const Eigen::Index n_v = model_->nv, n_u = model_->nu;
    motion.J_q.resize(n_v, n_v);
    motion.J_v.resize(n_v, n_v);
    motion.J_u.resize(n_v, n_u);
    motion.f.resize(n_v);
    q_ = q;
    v_ = v;
    std::fill_n(data_->ctrl, model_->nu, 0.0);
    // of f by an entry of q_ or v_, with what is known of the state without it
    const auto differences = [&](double& entry, double step, int known, auto&& column) {
      const double at = entry;
      entry = at + step;
      accelerate(known, after_);
      entry = at - step;
      accelerate(known, before_);
      entry = at;
      column = (after_ - before_) / (2.0 * step);
    };
    for (Eigen::Index i = 0; i < n_v; ++i)
      differences(q_[i], kOfPosition, mjSTAGE_NONE, motion.J_q.col(i));
    accelerate(mjSTAGE_NONE, motion.f);
    for (Eigen::Index i = 0; i < n_v; ++i)
      differences(v_[i], kOfVelocity, mjSTAGE_POS, motion.J_v.col(i));
    accelerate(mjSTAGE_POS, motion.f);
    for (Eigen::Index i = 0; i < n_u; ++i) {
      data_->ctrl[i] = 1.0;
      accelerate(mjSTAGE_VEL, after_);
      data_->ctrl[i] = 0.0;
      motion.J_u.col(i) = after_ - motion.f;
    }
    invert_inertia(motion.M_inverse);
    motion.N_q.setIdentity(n_v, n_v);
    motion.N_q_inverse.setIdentity(n_v, n_v);
    for (Eigen::Index i = 0; i < n_v; ++i) {
      if (coordinates_[static_cast<std::size_t>(i)].kind != Kind::kRotation) continue;
      const Matrix3d J = scene::left_jacobian(q.segment<3>(i));
      motion.N_q_inverse.block<3, 3>(i, i) = J;
      motion.N_q.block<3, 3>(i, i) = J.inverse();
      i += 2;
    }
  }

  scene::Place place(int body) const noexcept override {
    const RootBody& of = roots_[static_cast<std::size_t>(body)];
    const Matrix3d R = matrix(data_->xmat + 9 * of.root);
    return {vector(data_->xpos + 3 * of.root) + R * of.p_BC, R};
  }

  void jacobian(int body, const Vector3d& p_WP, Eigen::Ref<MatrixXd> J) const noexcept override {
    mj_jac(model_, data_, jacobian_.data(), nullptr, p_WP.data(),
           roots_[static_cast<std::size_t>(body)].root);
    J.noalias() = jacobian_.lazyProduct(T_);
  }

 private:
  /// A rigid body's outermost one in the file, and where its centre of mass is from there.
  struct RootBody {
    int root;
    Vector3d p_BC;
  };

  void refuse() const {
    const char* expected = "joints, motors and free bodies that contacts and gravity move";
    loaded_.refuse_constraints(expected);
    for (int joint = 0; joint < model_->njnt; ++joint) {
      if (model_->jnt_type[joint] == mjJNT_BALL) {
        loaded_.fail("hinges, slides and free joints",
                     "a ball joint, " + loaded_.quoted(mjOBJ_JOINT, joint));
      }
    }
    for (int dof = 0; dof < model_->nv; ++dof) {
      if (model_->dof_frictionloss[dof] != 0.0) {
        loaded_.fail(
            "joints that have no friction of their own",
            "frictionloss of joint " + loaded_.quoted(mjOBJ_JOINT, model_->dof_jntid[dof]));
      }
    }
    for (int body = 1; body < model_->nbody; ++body) {
      if (model_->body_mocapid[body] >= 0)
        loaded_.fail(expected, "the mocap body " + loaded_.quoted(mjOBJ_BODY, body));
    }
    for (int actuator = 0; actuator < model_->nu; ++actuator) refuse_all_but_motor(actuator);
    if (model_->nu == 0) loaded_.fail("at least one motor, say <motor joint=…/>", "none");
  }

  void refuse_all_but_motor(int actuator) const {
    const char* expected = "motors (<motor joint=…/>) of hinges and slides";
    const std::string called = "the actuator " + loaded_.quoted(mjOBJ_ACTUATOR, actuator);
    const int transmission = model_->actuator_trntype[actuator];
    if (transmission != mjTRN_JOINT && transmission != mjTRN_JOINTINPARENT)
      loaded_.fail(expected, called + ", which is at no joint");
    const int joint = model_->actuator_trnid[2 * actuator];
    if (model_->jnt_type[joint] == mjJNT_FREE)
      loaded_.fail(expected, called + " of the free joint " + loaded_.quoted(mjOBJ_JOINT, joint));
    if (model_->actuator_dyntype[actuator] != mjDYN_NONE ||
        model_->actuator_gaintype[actuator] != mjGAIN_FIXED ||
        model_->actuator_biastype[actuator] != mjBIAS_NONE) {
      loaded_.fail(expected, called + ", which is a servo, a damper, a cylinder or a muscle");
    }
  }

  void go_home() {
    loaded_.go_home();
    if (model_->nkey > 0)
      notes_.push_back("it is at home in the keyframe " + loaded_.quoted(mjOBJ_KEY, 0));
    coordinates_of_ = Coordinates(loaded_);
    home_.setZero(model_->nv);
    VectorXd at_rest(model_->nv);
    coordinates_of_.from_mujoco(data_, home_, at_rest);
  }

  /// The world, and every body with what is fixed to it.
  void read_bodies() {
    for (int body = 0; body < model_->nbody; ++body) {
      if (model_->body_weldid[body] != body) continue;
      scene::RigidBody rigid;
      Rigid read;
      if (body > 0) read = loaded_.rigid(body);
      rigid.object = scene::make_object(named(mjOBJ_BODY, body, "body"),
                                        body == 0 ? 0.0 : read.mass, read.inertia, 0.0, {});
      rigid.driven = false;
      rigid.parent = body == 0 ? 0 : rigid_of(model_->body_parentid[body]);
      for (int of = body; of > 0; of = model_->body_parentid[of]) {
        for (int actuator = 0; actuator < model_->nu; ++actuator)
          rigid.driven |= model_->jnt_bodyid[model_->actuator_trnid[2 * actuator]] == of;
      }
      roots_.push_back(
          {body, read.R_WB.transpose() * (read.p_WC - vector(data_->xpos + 3 * body))});
      places_.push_back({read.p_WC, read.R_WB});
      bodies_.push_back(std::move(rigid));
    }
  }

  /// A name that may be a key: of what the file names not, its kind and number.
  std::string named(int type, int id, const std::string& kind) const {
    const char* given = mj_id2name(model_, type, id);
    return given != nullptr && *given != '\0' ? given : kind + "_" + std::to_string(id);
  }

  int rigid_of(int body) const {
    const int root = model_->body_weldid[body];
    return static_cast<int>(std::find_if(roots_.begin(), roots_.end(),
                                         [&](const RootBody& of) { return of.root == root; }) -
                            roots_.begin());
  }

  void read_surfaces() {
    std::vector<scene::Union> parts(bodies_.size());
    for (int geom = 0; geom < model_->ngeom; ++geom) {
      if (!loaded_.collides(geom)) {
        notes_.push_back("geom " + loaded_.quoted(mjOBJ_GEOM, geom) +
                         " collides with nothing (contype and conaffinity 0): it is a picture and "
                         "no surface");
        continue;
      }
      scene::Surface surface;
      const int owner = model_->geom_bodyid[geom];
      surface.body = rigid_of(owner);
      const auto at = static_cast<std::size_t>(surface.body);
      surface.owner = named(mjOBJ_BODY, owner, "body");
      surface.name = named(mjOBJ_GEOM, geom, surface.owner + "_geom");
      surface.friction = model_->geom_friction[3 * geom];
      surface.is_plane = model_->geom_type[geom] == mjGEOM_PLANE;
      const Matrix3d R_BW = places_[at].R.transpose();
      surface.part.p_BP = R_BW * (vector(data_->geom_xpos + 3 * geom) - places_[at].p);
      surface.part.R_BP = R_BW * matrix(data_->geom_xmat + 9 * geom);
      scene::Object& object = bodies_[at].object;
      object.friction = std::max(object.friction, surface.friction);
      if (!surface.is_plane) {
        surface.part.shape = loaded_.shape(geom, parts[at], notes_);
        parts[at].parts.push_back(surface.part);
      }
      surfaces_.push_back(std::move(surface));
    }
    for (std::size_t i = 0; i < bodies_.size(); ++i)
      bodies_[i].object.parts = std::make_shared<const scene::Union>(std::move(parts[i]));
  }

  void name_coordinates() {
    coordinates_.resize(static_cast<std::size_t>(model_->nv));
    for (int joint = 0; joint < model_->njnt; ++joint) {
      const auto dof = static_cast<std::size_t>(model_->jnt_dofadr[joint]);
      const int of = rigid_of(model_->jnt_bodyid[joint]);
      const std::string called = named(mjOBJ_JOINT, joint, "joint");
      if (model_->jnt_type[joint] != mjJNT_FREE) {
        const bool turns = model_->jnt_type[joint] == mjJNT_HINGE;
        coordinates_[dof] = {turns ? Kind::kHinge : Kind::kSlide, called, called + "_rate", of};
        if (model_->jnt_limited[joint] != 0) {
          const mjtNum* range = model_->jnt_range + 2 * joint;
          notes_.push_back("joint \"" + called + "\" has limits, " + base::words("%g", range[0]) +
                           base::words(" to %g ", range[1]) + (turns ? "rad" : "m") +
                           ", which the LCS does not know: bound it in the problem");
        }
        continue;
      }
      const std::string body = named(mjOBJ_BODY, model_->jnt_bodyid[joint], "body");
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::string along(1, static_cast<char>('x' + axis));
        coordinates_[dof + axis] = {Kind::kPosition, body + "_" + along,
                                    body + "_velocity_" + along, of};
        coordinates_[dof + 3 + axis] = {Kind::kRotation, body + "_turn_" + along,
                                        body + "_turn_rate_" + along, of};
      }
    }
  }

  void read_motors() {
    constexpr double kAny = std::numeric_limits<double>::infinity();
    for (int actuator = 0; actuator < model_->nu; ++actuator) {
      const int joint = model_->actuator_trnid[2 * actuator];
      const bool limited = model_->actuator_ctrllimited[actuator] != 0;
      const mjtNum* range = model_->actuator_ctrlrange + 2 * actuator;
      motors_.push_back(
          {named(mjOBJ_ACTUATOR, actuator, named(mjOBJ_JOINT, joint, "joint") + "_motor"),
           model_->jnt_type[joint] == mjJNT_HINGE, limited ? range[0] : -kAny,
           limited ? range[1] : kAny});
      if (model_->actuator_forcelimited[actuator] != 0) {
        notes_.push_back("the forcerange of motor \"" + motors_.back().name +
                         "\" is left out: a plan knows its ctrlrange alone");
      }
    }
  }

  /// What is left is smooth.
  void drop_constraints() {
    model_->opt.disableflags |= mjDSBL_CONSTRAINT | mjDSBL_CONTACT | mjDSBL_CLAMPCTRL;
    std::fill_n(model_->actuator_forcelimited, model_->nu, mjtByte{0});
  }

  /// v̇ at q_, v_ with the inputs of data_. @param known which stages are of this state already
  void accelerate(int known, Eigen::Ref<VectorXd> a) {
    coordinates_of_.to_mujoco(q_, v_, data_);
    mj_forwardSkip(model_, data_, known, 1);
    coordinates_of_.acceleration(data_, v_, a);
  }

  void invert_inertia(MatrixXd& M_inverse) {
    mj_fullM(model_, M_.data(), data_->qM);
    coordinates_of_.velocity_map(data_, T_);
    // with T at most dense in blocks of 6, products without a temporary
    inertia_.noalias() = M_.lazyProduct(T_);
    M_inverse.noalias() = T_.transpose().lazyProduct(inertia_);
    factor_.compute(M_inverse);
    M_inverse.setIdentity(model_->nv, model_->nv);
    factor_.solveInPlace(M_inverse);
  }

  Loaded loaded_;
  mjModel* model_;
  mjData* data_;
  Coordinates coordinates_of_;
  std::vector<RootBody> roots_;
  std::vector<scene::Place> places_;  // of the rigid bodies at home
  std::vector<std::string> notes_;
  RowMajor M_;
  mutable RowMajor jacobian_;
  MatrixXd T_, inertia_;  // v of MuJoCo is T v
  Eigen::LLT<MatrixXd> factor_;
  VectorXd q_, v_, before_, after_;
};

}  // namespace

bool has_actuators(const std::string& file) { return Loaded(file).model()->nu > 0; }

MechanismFile read_mechanism(const std::string& file) {
  auto mechanism = std::make_shared<MujocoMechanism>(file);
  std::vector<std::string> notes = mechanism->take_notes();
  return {std::move(mechanism), std::move(notes)};
}

}  // namespace c3rt::mjcf
