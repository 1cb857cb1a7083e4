#include "controller/mjcf/object.hpp"

#include <fstream>
#include <limits>
#include <sstream>
#include <utility>

#include "controller/base/words.hpp"
#include "controller/mjcf/loaded.hpp"

namespace c3rt::mjcf {
namespace {

using Eigen::Vector3d;

class Reader {
 public:
  explicit Reader(const std::string& file)
      : loaded_(file), model_(loaded_.model()), data_(loaded_.data()) {}

  ObjectFile read() {
    const char* expected = "an object that contacts and gravity alone move";
    loaded_.refuse_constraints(expected);
    if (model_->nu > 0) fail(expected, "the actuator " + quoted(mjOBJ_ACTUATOR, 0));
    find_body();
    read_inertia();
    read_geoms();
    read_tags();
    note_file();
    scene::Object object = scene::make_object(loaded_.name(mjOBJ_BODY, body_), rigid_.mass,
                                              rigid_.inertia, friction_, std::move(parts_));
    object.tags = std::move(tags_);
    note_size(object);
    return {std::move(object), p_body_com_, std::move(notes_)};
  }

 private:
  void find_body() {
    std::string free;
    int count = 0;
    for (int joint = 0; joint < model_->njnt; ++joint) {
      if (model_->jnt_type[joint] != mjJNT_FREE) {
        fail(
            "a rigid object: a body with a free joint and no other one (objects with joints are "
            "not planned with)",
            std::string(Loaded::type_of_joint(model_->jnt_type[joint])) + ", the joint " +
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

  bool is_fixed_to_body(int other) const { return loaded_.is_fixed_to(other, body_); }

  void read_inertia() {
    rigid_ = loaded_.rigid(body_);
    if (!(rigid_.mass > 0.0)) fail("an object with a mass", base::words("%g kg", rigid_.mass));
    p_body_com_ = rigid_.R_WB.transpose() * (rigid_.p_WC - vector(data_->xpos + 3 * body_));
    if (p_body_com_.norm() > 1e-6) {
      notes_.push_back("the centre of mass is " + base::words("%.4g", 1e3 * p_body_com_.norm()) +
                       " mm from the origin of body " + quoted(mjOBJ_BODY, body_) +
                       ": poses are those of the centre of mass");
    }
    if (vector(data_->xpos + 3 * body_).norm() > 0.0 || !rigid_.R_WB.isIdentity())
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
      if (!loaded_.collides(geom)) {
        notes_.push_back(called + " collides with nothing (contype and conaffinity 0): it is a " +
                         "picture and no part of the surface");
        continue;
      }
      parts_.parts.push_back(
          {loaded_.shape(geom, parts_, notes_),
           rigid_.R_WB.transpose() * (vector(data_->geom_xpos + 3 * geom) - rigid_.p_WC),
           rigid_.R_WB.transpose() * matrix(data_->geom_xmat + 9 * geom)});
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
      const char* given = mj_id2name(model_, mjOBJ_SITE, site);
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
      tag.p_BT = rigid_.R_WB.transpose() * (vector(data_->site_xpos + 3 * site) - rigid_.p_WC);
      tag.R_BT = rigid_.R_WB.transpose() * matrix(data_->site_xmat + 9 * site);
      tags_.push_back(tag);
    }
  }

  /// What the compiled model no longer tells.
  void note_file() {
    std::ifstream stream(loaded_.file());
    std::stringstream text;
    text << stream.rdbuf();
    const std::string words = text.str();
    const auto has = [&](const char* word) { return words.find(word) != std::string::npos; };
    if ((has("euler=") || has("axisangle=")) && !has("angle=\"radian\""))
      notes_.emplace_back("its angles are degrees, as no angle=\"radian\" says otherwise");
    if (!has("mass=") && !has("density=")) {
      notes_.push_back("no mass and no density is given: MuJoCo takes 1000 kg/m3, which makes " +
                       base::words("%.3g kg", rigid_.mass));
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

  [[noreturn]] void fail(const std::string& expected, const std::string& got) const {
    loaded_.fail(expected, got);
  }
  std::string quoted(int type, int id) const { return loaded_.quoted(type, id); }

  Loaded loaded_;
  const mjModel* model_;
  const mjData* data_;
  int body_ = -1;
  Rigid rigid_;
  double friction_ = 0.0;
  Vector3d p_body_com_ = Vector3d::Zero();
  scene::Union parts_;
  std::vector<scene::Tag> tags_;
  std::vector<std::string> notes_;
};

}  // namespace

ObjectFile read_object(const std::string& file) { return Reader(file).read(); }

}  // namespace c3rt::mjcf
