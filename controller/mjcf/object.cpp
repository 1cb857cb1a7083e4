#include "controller/mjcf/object.hpp"

#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <memory>
#include <set>
#include <sstream>
#include <utility>

#include <Eigen/Geometry>
#include <mujoco/mujoco.h>

#include "controller/base/words.hpp"

namespace c3rt::mjcf {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

struct ModelDeleter {
  void operator()(mjModel* model) const noexcept { mj_deleteModel(model); }
};
struct DataDeleter {
  void operator()(mjData* data) const noexcept { mj_deleteData(data); }
};

Vector3d vector(const mjtNum* from) { return Eigen::Map<const Vector3d>(from); }
Matrix3d matrix(const mjtNum* from) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(from);
}

const char* type_name(int geom_type) {
  switch (geom_type) {
    case mjGEOM_PLANE:
      return "a plane";
    case mjGEOM_HFIELD:
      return "a height field";
    case mjGEOM_ELLIPSOID:
      return "an ellipsoid";
    default:
      return "of a type that is not known";
  }
}

const char* type_name_of_joint(int joint_type) {
  switch (joint_type) {
    case mjJNT_BALL:
      return "a ball joint";
    case mjJNT_SLIDE:
      return "a slide";
    default:
      return "a hinge";
  }
}

class Reader {
 public:
  explicit Reader(const std::string& file) : file_(file) {
    std::array<char, 1000> error{};
    model_.reset(mj_loadXML(file.c_str(), nullptr, error.data(), static_cast<int>(error.size())));
    if (!model_) fail(std::string("a model that MuJoCo can read"), error.data());
    data_.reset(mj_makeData(model_.get()));
    mj_kinematics(model_.get(), data_.get());
  }

  ObjectFile read() {
    refuse_constraints();
    find_body();
    read_inertia();
    read_geoms();
    read_tags();
    note_file();
    scene::Object object =
        scene::make_object(name(mjOBJ_BODY, body_), mass_, inertia_, friction_, std::move(parts_));
    object.tags = std::move(tags_);
    note_size(object);
    return {std::move(object), p_body_com_, std::move(notes_)};
  }

 private:
  [[noreturn]] void fail(const std::string& expected, const std::string& got) const {
    throw Error(file_ + ": expected " + expected + ", got " + got);
  }

  std::string name(int type, int id) const {
    const char* given = mj_id2name(model_.get(), type, id);
    return given != nullptr && *given != '\0' ? given : "number " + std::to_string(id);
  }
  std::string quoted(int type, int id) const { return "\"" + name(type, id) + "\""; }

  void refuse_constraints() const {
    const char* expected = "an object that contacts and gravity alone move";
    if (model_->ntendon > 0) fail(expected, "the tendon " + quoted(mjOBJ_TENDON, 0));
    if (model_->neq > 0) fail(expected, "the equality " + quoted(mjOBJ_EQUALITY, 0));
    if (model_->nu > 0) fail(expected, "the actuator " + quoted(mjOBJ_ACTUATOR, 0));
  }

  void find_body() {
    std::string free;
    int count = 0;
    for (int joint = 0; joint < model_->njnt; ++joint) {
      if (model_->jnt_type[joint] != mjJNT_FREE) {
        fail(
            "a rigid object: a body with a free joint and no other one (objects with joints are "
            "not planned with)",
            std::string(type_name_of_joint(model_->jnt_type[joint])) + ", the joint " +
                quoted(mjOBJ_JOINT, joint) + " of body " +
                quoted(mjOBJ_BODY, model_->jnt_bodyid[joint]));
      }
      body_ = model_->jnt_bodyid[joint];
      free += (count++ > 0 ? ", " : "") + quoted(mjOBJ_BODY, body_);
      if (model_->jnt_stiffness[joint] != 0.0) refuse_joint("stiffness", joint);
    }
    if (count == 0) fail("one body with a free joint, say <freejoint/>", "none");
    if (count > 1) fail("one body with a free joint, a file for each object", free);
    for (int dof = 0; dof < model_->nv; ++dof) {
      if (model_->dof_damping[dof] != 0.0) refuse_joint("damping", 0);
      if (model_->dof_armature[dof] != 0.0) refuse_joint("armature", 0);
      if (model_->dof_frictionloss[dof] != 0.0) refuse_joint("frictionloss", 0);
    }
  }

  [[noreturn]] void refuse_joint(const char* what, int joint) const {
    fail("a free joint that nothing holds back",
         std::string(what) + " of joint " + quoted(mjOBJ_JOINT, joint));
  }

  bool is_fixed_to_body(int other) const {
    return other != 0 && model_->body_weldid[other] == body_;
  }

  /// Of the body and those that are fixed to it.
  void read_inertia() {
    const Matrix3d R_WB = matrix(data_->xmat + 9 * body_);
    Vector3d p_WC = Vector3d::Zero();
    for (int i = 0; i < model_->nbody; ++i) {
      if (!is_fixed_to_body(i)) continue;
      mass_ += model_->body_mass[i];
      p_WC += model_->body_mass[i] * vector(data_->xipos + 3 * i);
    }
    if (!(mass_ > 0.0)) fail("an object with a mass", base::words("%g kg", mass_));
    p_WC /= mass_;
    for (int i = 0; i < model_->nbody; ++i) {
      if (!is_fixed_to_body(i)) continue;
      const Matrix3d R_WI = matrix(data_->ximat + 9 * i);
      const Vector3d from_com = vector(data_->xipos + 3 * i) - p_WC;
      inertia_ += R_WI * vector(model_->body_inertia + 3 * i).asDiagonal() * R_WI.transpose() +
                  model_->body_mass[i] * (from_com.squaredNorm() * Matrix3d::Identity() -
                                          from_com * from_com.transpose());
    }
    inertia_ = (R_WB.transpose() * inertia_ * R_WB).eval();
    inertia_ = 0.5 * (inertia_ + inertia_.transpose()).eval();
    p_WC_ = p_WC;
    R_WB_ = R_WB;
    p_body_com_ = R_WB.transpose() * (p_WC - vector(data_->xpos + 3 * body_));
    if (p_body_com_.norm() > 1e-6) {
      notes_.push_back("the centre of mass is " + base::words("%.4g", 1e3 * p_body_com_.norm()) +
                       " mm from the origin of body " + quoted(mjOBJ_BODY, body_) +
                       ": poses are those of the centre of mass");
    }
    if (vector(data_->xpos + 3 * body_).norm() > 0.0 || !R_WB.isIdentity())
      notes_.emplace_back(
          "where the file places the body is left out: a scenario says where it is");
  }

  void read_geoms() {
    double least_friction = std::numeric_limits<double>::infinity();
    for (int geom = 0; geom < model_->ngeom; ++geom) {
      const std::string called = "geom " + quoted(mjOBJ_GEOM, geom);
      if (!is_fixed_to_body(model_->geom_bodyid[geom])) {
        notes_.push_back(called + " of body " + quoted(mjOBJ_BODY, model_->geom_bodyid[geom]) +
                         " is no part of the object and is left out");
        continue;
      }
      if (model_->geom_contype[geom] == 0 && model_->geom_conaffinity[geom] == 0) {
        notes_.push_back(called + " collides with nothing (contype and conaffinity 0): it is a " +
                         "picture and no part of the surface");
        continue;
      }
      parts_.parts.push_back({shape_of(geom, called),
                              R_WB_.transpose() * (vector(data_->geom_xpos + 3 * geom) - p_WC_),
                              R_WB_.transpose() * matrix(data_->geom_xmat + 9 * geom)});
      friction_ = std::max(friction_, model_->geom_friction[3 * geom]);
      least_friction = std::min(least_friction, model_->geom_friction[3 * geom]);
    }
    if (parts_.parts.empty())
      fail("at least one geom that collides (contype or conaffinity not 0)", "none");
    if (parts_.parts.size() > static_cast<std::size_t>(scene::Union::kMostParts)) {
      fail("at most " + std::to_string(scene::Union::kMostParts) + " geoms that collide",
           std::to_string(parts_.parts.size()));
    }
    if (least_friction < friction_) {
      notes_.push_back("its geoms have frictions from " + base::words("%g", least_friction) +
                       " to " + base::words("%g", friction_) + ": it counts as one of the largest");
    }
  }

  /// Sites that are called tag and a digit: tag36h11_ID, boxes with half of the black square's edge
  /// as their first two sizes, whose z leaves the surface.
  void read_tags() {
    const std::string family = "tag36h11_";
    for (int site = 0; site < model_->nsite; ++site) {
      const char* given = mj_id2name(model_.get(), mjOBJ_SITE, site);
      const std::string called = given != nullptr ? given : "";
      if (called.rfind("tag", 0) != 0 || called.size() < 4 || called[3] < '0' || called[3] > '9')
        continue;
      if (!is_fixed_to_body(model_->site_bodyid[site])) {
        notes_.push_back("site \"" + called + "\" is on no part of the object and is left out");
        continue;
      }
      scene::Tag tag;
      const std::string id = called.substr(0, family.size()) == family && called.size() < 13
                                 ? called.substr(family.size())
                                 : "";
      const bool digits = !id.empty() && id.find_first_not_of("0123456789") == std::string::npos;
      if (digits) tag.id = std::stoi(id);
      if (!digits || tag.id >= scene::Tag::kKinds || std::to_string(tag.id) != id) {
        fail("tags called " + family + "0 to " + family + std::to_string(scene::Tag::kKinds - 1),
             "the site \"" + called + "\"");
      }
      const mjtNum* half = model_->site_size + 3 * site;
      if (model_->site_type[site] != mjGEOM_BOX || half[0] != half[1]) {
        fail(
            "a tag as a square: type=\"box\" with half of the black square's edge as its first two "
            "sizes",
            "the site \"" + called + "\"" +
                (model_->site_type[site] != mjGEOM_BOX
                     ? ", which is no box"
                     : " of " + base::words("%g", 2e3 * half[0]) +
                           base::words(" x %g mm", 2e3 * half[1])));
      }
      tag.size = 2.0 * half[0];
      tag.p_BT = R_WB_.transpose() * (vector(data_->site_xpos + 3 * site) - p_WC_);
      tag.R_BT = R_WB_.transpose() * matrix(data_->site_xmat + 9 * site);
      tags_.push_back(tag);
    }
  }

  scene::Shape shape_of(int geom, const std::string& called) {
    const Vector3d size = vector(model_->geom_size + 3 * geom);
    switch (model_->geom_type[geom]) {
      case mjGEOM_SPHERE:
        return scene::Shape::sphere(size[0]);
      case mjGEOM_CAPSULE:
        return scene::Shape::capsule(size[0], size[1]);
      case mjGEOM_CYLINDER:
        return scene::Shape::cylinder(size[0], size[1]);
      case mjGEOM_BOX:
        return scene::Shape::box(size);
      case mjGEOM_MESH:
        return hull_of(model_->geom_dataid[geom], called);
      default:
        fail("spheres, boxes, capsules, cylinders and meshes",
             called + ", which is " + type_name(model_->geom_type[geom]));
    }
  }

  /// The corners of the hull that MuJoCo computed, which are fewer than those of the mesh.
  scene::Shape hull_of(int mesh, const std::string& called) {
    std::vector<Vector3d> corners;
    const auto add = [&](int vertex) {
      const float* at = model_->mesh_vert + 3 * (model_->mesh_vertadr[mesh] + vertex);
      corners.emplace_back(at[0], at[1], at[2]);
    };
    const int hull = model_->mesh_graphadr[mesh];
    if (hull >= 0) {
      // the numbers of vertices and faces, an address for each vertex, then which vertex it is
      const int* graph = model_->mesh_graph + hull;
      for (int i = 0; i < graph[0]; ++i) add(graph[2 + graph[0] + i]);
    } else {
      for (int i = 0; i < model_->mesh_vertnum[mesh]; ++i) add(i);
    }
    if (corners.size() > kMostCorners) {
      fail("meshes with a convex hull of at most " + std::to_string(kMostCorners) + " corners",
           called + " with " + std::to_string(corners.size()) + " (a simpler mesh will do)");
    }
    // a file may name a corner once for each face that has it
    std::set<std::array<float, 3>> different;
    for (int i = 0; i < model_->mesh_vertnum[mesh]; ++i) {
      const float* at = model_->mesh_vert + 3 * (model_->mesh_vertadr[mesh] + i);
      different.insert({at[0], at[1], at[2]});
    }
    if (corners.size() < different.size()) {
      notes_.push_back(called + " counts as its convex hull, " + std::to_string(corners.size()) +
                       " of the mesh's " + std::to_string(different.size()) +
                       " corners; hollows need several geoms");
    }
    try {
      parts_.meshes.push_back(std::make_shared<const scene::ConvexMesh>(std::move(corners)));
    } catch (const std::invalid_argument& e) {
      throw Error(file_ + ": " + called + ": " + e.what());
    }
    return scene::Shape::convex_mesh(*parts_.meshes.back());
  }

  /// What the compiled model no longer tells.
  void note_file() {
    std::ifstream stream(file_);
    std::stringstream text;
    text << stream.rdbuf();
    const std::string words = text.str();
    const auto has = [&](const char* word) { return words.find(word) != std::string::npos; };
    if ((has("euler=") || has("axisangle=")) && !has("angle=\"radian\""))
      notes_.emplace_back("its angles are degrees, as no angle=\"radian\" says otherwise");
    if (!has("mass=") && !has("density=")) {
      notes_.push_back("no mass and no density is given: MuJoCo takes 1000 kg/m3, which makes " +
                       base::words("%.3g kg", mass_));
    }
  }

  void note_size(const scene::Object& object) {
    const scene::Shape shape = object.shape();
    double largest = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d along = Vector3d::Unit(axis);
      largest = std::max(largest, scene::reach(shape, along) + scene::reach(shape, -along));
    }
    if (largest > 1.0) {
      notes_.push_back("it is " + base::words("%.3g", largest) +
                       " m large: is its file in millimetres? (scale=\"0.001 0.001 0.001\")");
    }
    if (largest < 0.005)
      notes_.push_back("it is " + base::words("%.3g", 1e3 * largest) +
                       " mm small: is its scale right?");
  }

  static constexpr std::size_t kMostCorners = 400;

  std::string file_;
  std::unique_ptr<mjModel, ModelDeleter> model_;
  std::unique_ptr<mjData, DataDeleter> data_;
  int body_ = -1;
  double mass_ = 0.0, friction_ = 0.0;
  Matrix3d inertia_ = Matrix3d::Zero(), R_WB_ = Matrix3d::Identity();
  Vector3d p_WC_ = Vector3d::Zero(), p_body_com_ = Vector3d::Zero();
  scene::Union parts_;
  std::vector<scene::Tag> tags_;
  std::vector<std::string> notes_;
};

}  // namespace

ObjectFile read_object(const std::string& file) { return Reader(file).read(); }

}  // namespace c3rt::mjcf
