#include "controller/mjcf/loaded.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <stdexcept>
#include <utility>

namespace c3rt::mjcf {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::size_t kMostCorners = 400;

const char* type_of_geom(int geom_type) {
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

}  // namespace

Loaded::Loaded(std::string file) : file_(std::move(file)) {
  std::array<char, 1000> error{};
  model_.reset(mj_loadXML(file_.c_str(), nullptr, error.data(), static_cast<int>(error.size())));
  if (!model_) fail("a model that MuJoCo can read", error.data());
  data_.reset(mj_makeData(model_.get()));
  mj_kinematics(model_.get(), data_.get());
}

void Loaded::go_home() {
  std::copy_n(model_->nkey > 0 ? model_->key_qpos : model_->qpos0, model_->nq, data_->qpos);
  std::fill_n(data_->qvel, model_->nv, 0.0);
  mj_kinematics(model_.get(), data_.get());
}

void Loaded::fail(const std::string& expected, const std::string& got) const {
  throw Error(file_ + ": expected " + expected + ", got " + got);
}

std::string Loaded::name(int type, int id) const {
  const char* given = mj_id2name(model_.get(), type, id);
  return given != nullptr && *given != '\0' ? given : "number " + std::to_string(id);
}

const char* Loaded::type_of_joint(int joint_type) {
  switch (joint_type) {
    case mjJNT_BALL:
      return "a ball joint";
    case mjJNT_SLIDE:
      return "a slide";
    default:
      return "a hinge";
  }
}

void Loaded::refuse_constraints(const char* expected) const {
  if (model_->ntendon > 0) fail(expected, "the tendon " + quoted(mjOBJ_TENDON, 0));
  if (model_->neq > 0) fail(expected, "the equality " + quoted(mjOBJ_EQUALITY, 0));
}

Rigid Loaded::rigid(int root) const {
  Rigid result;
  result.R_WB = matrix(data_->xmat + 9 * root);
  for (int i = 0; i < model_->nbody; ++i) {
    if (!is_fixed_to(i, root)) continue;
    result.mass += model_->body_mass[i];
    result.p_WC += model_->body_mass[i] * vector(data_->xipos + 3 * i);
  }
  if (result.mass > 0.0) {
    result.p_WC /= result.mass;
  } else {
    result.p_WC = vector(data_->xpos + 3 * root);
  }
  for (int i = 0; i < model_->nbody; ++i) {
    if (!is_fixed_to(i, root)) continue;
    const Matrix3d R_WI = matrix(data_->ximat + 9 * i);
    const Vector3d from_com = vector(data_->xipos + 3 * i) - result.p_WC;
    result.inertia += R_WI * vector(model_->body_inertia + 3 * i).asDiagonal() * R_WI.transpose() +
                      model_->body_mass[i] * (from_com.squaredNorm() * Matrix3d::Identity() -
                                              from_com * from_com.transpose());
  }
  result.inertia = (result.R_WB.transpose() * result.inertia * result.R_WB).eval();
  result.inertia = 0.5 * (result.inertia + result.inertia.transpose()).eval();
  return result;
}

scene::Shape Loaded::shape(int geom, scene::Union& meshes, std::vector<std::string>& notes) const {
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
      return hull(geom, meshes, notes);
    default:
      fail("spheres, boxes, capsules, cylinders and meshes",
           "geom " + quoted(mjOBJ_GEOM, geom) + ", which is " +
               type_of_geom(model_->geom_type[geom]));
  }
}

/// The corners of the hull that MuJoCo computed, which are fewer than those of the mesh.
scene::Shape Loaded::hull(int geom, scene::Union& meshes, std::vector<std::string>& notes) const {
  const int mesh = model_->geom_dataid[geom];
  const std::string called = "geom " + quoted(mjOBJ_GEOM, geom);
  std::vector<Vector3d> corners;
  const auto add = [&](int vertex) {
    const float* at = model_->mesh_vert + 3 * (model_->mesh_vertadr[mesh] + vertex);
    corners.emplace_back(at[0], at[1], at[2]);
  };
  const int address = model_->mesh_graphadr[mesh];
  if (address >= 0) {
    // the numbers of vertices and faces, an address for each vertex, then which vertex it is
    const int* graph = model_->mesh_graph + address;
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
    notes.push_back(called + " counts as its convex hull, " + std::to_string(corners.size()) +
                    " of the mesh's " + std::to_string(different.size()) +
                    " corners; hollows need several geoms");
  }
  try {
    meshes.meshes.push_back(std::make_shared<const scene::ConvexMesh>(std::move(corners)));
  } catch (const std::invalid_argument& e) {
    throw Error(file_ + ": " + called + ": " + e.what());
  }
  return scene::Shape::convex_mesh(*meshes.meshes.back());
}

}  // namespace c3rt::mjcf
