#pragma once
// A MuJoCo model (MJCF) as MuJoCo compiled it: what every reader of this room needs.
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <mujoco/mujoco.h>

#include "controller/mjcf/error.hpp"
#include "controller/scene/shape.hpp"

namespace c3rt::mjcf {

inline Eigen::Vector3d vector(const mjtNum* from) {
  return Eigen::Map<const Eigen::Vector3d>(from);
}
inline Eigen::Matrix3d matrix(const mjtNum* from) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(from);
}

/// What is fixed to each other, as one body about its centre of mass C with the axes B of its
/// outermost body.
struct Rigid {
  double mass = 0.0;                                   // [kg]
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();   // about C, in B [kg m²]
  Eigen::Vector3d p_WC = Eigen::Vector3d::Zero();      // in the file's place [m]
  Eigen::Matrix3d R_WB = Eigen::Matrix3d::Identity();  // in the file's place
};

class Loaded {
 public:
  /// In the pose of the file. @throws Error where MuJoCo refuses it
  explicit Loaded(std::string file);

  const std::string& file() const noexcept { return file_; }
  mjModel* model() const noexcept { return model_.get(); }
  mjData* data() const noexcept { return data_.get(); }

  /// The pose of the first keyframe; where there is none that of the file. At rest.
  void go_home();

  [[noreturn]] void fail(const std::string& expected, const std::string& got) const;
  /// By its name, else its number.
  std::string name(int type, int id) const;
  std::string quoted(int type, int id) const { return "\"" + name(type, id) + "\""; }
  static const char* type_of_joint(int joint_type);
  /// Tendons and equalities move what they hold in ways that no plan knows of.
  /// @throws Error naming the first of them
  void refuse_constraints(const char* expected) const;
  /// Whether a body is this one or fixed to it; 0: to the world.
  bool is_fixed_to(int body, int root) const { return model_->body_weldid[body] == root; }
  /// Whether anything can touch it; else it is a picture.
  bool collides(int geom) const {
    return model_->geom_contype[geom] != 0 || model_->geom_conaffinity[geom] != 0;
  }

  /// Of a body and what is fixed to it; where that has no mass, about the body's origin.
  Rigid rigid(int root) const;
  /// Of a geom that is a sphere, box, capsule, cylinder or mesh: of that the convex hull.
  /// @param meshes gets the hull, which the shape points to  @param notes gets what it leaves out
  /// @throws Error naming another geom
  scene::Shape shape(int geom, scene::Union& meshes, std::vector<std::string>& notes) const;

 private:
  struct ModelDeleter {
    void operator()(mjModel* model) const noexcept { mj_deleteModel(model); }
  };
  struct DataDeleter {
    void operator()(mjData* data) const noexcept { mj_deleteData(data); }
  };
  scene::Shape hull(int geom, scene::Union& meshes, std::vector<std::string>& notes) const;

  std::string file_;
  std::unique_ptr<mjModel, ModelDeleter> model_;
  std::unique_ptr<mjData, DataDeleter> data_;
};

}  // namespace c3rt::mjcf
