#include "vision/virtual_cameras.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>

#include <GL/osmesa.h>
#include <dlfcn.h>
#include <opencv2/core.hpp>

#include "controller/base/random.hpp"
#include "vision/apriltag.hpp"

namespace c3rt::vision {
namespace {

constexpr float kNear = 0.05F, kFar = 10.0F;  // [m]
constexpr int kMaxGeoms = 400;
// the noise of a seed does not depend on where the cameras are
constexpr std::uint64_t kCalibrationStream = 0xD1342543DE82EF95;

struct OsMesaDeleter {
  void operator()(osmesa_context* context) const noexcept { OSMesaDestroyContext(context); }
};

/// MuJoCo looks for OSMesa among the symbols that the whole program sees. A library that was loaded
/// for a part of it alone, as Python loads its extensions, has none there, and MuJoCo would end the
/// program.
void show_osmesa_to_mujoco() {
  Dl_info library{};
  if (dladdr(reinterpret_cast<void*>(&OSMesaGetProcAddress), &library) != 0)
    dlopen(library.dli_fname, RTLD_NOW | RTLD_GLOBAL | RTLD_NOLOAD);
}

/// A geom's hull: all points within `radius` of the straight line from -half_axis to half_axis.
struct Hull {
  Eigen::Vector3d half_axis;
  double radius;
};
Hull hull_of(const mjvGeom& geom) {
  const Eigen::Vector3d axis(geom.mat[2], geom.mat[5], geom.mat[8]);
  switch (geom.type) {
    case mjGEOM_PLANE:
      return {Eigen::Vector3d::Zero(), std::numeric_limits<double>::infinity()};
    case mjGEOM_SPHERE:
      return {Eigen::Vector3d::Zero(), geom.size[0]};
    case mjGEOM_CAPSULE:
    case mjGEOM_CYLINDER:
      return {static_cast<double>(geom.size[2]) * axis, geom.size[0]};
    default:
      return {Eigen::Vector3d::Zero(),
              static_cast<double>(geom.size[0]) + geom.size[1] + geom.size[2]};
  }
}

/// The part of space that a region of the sensor sees: inside the four planes through the camera's
/// centre.
class Pyramid {
 public:
  Pyramid(const CameraModel& camera, const Roi& roi) : X_CW_(camera.X_WC.inverse()) {
    const double left = (roi.x - 0.5 - camera.cx) / camera.fx,
                 top = (roi.y - 0.5 - camera.cy) / camera.fy;
    const double right = left + roi.width / camera.fx, bottom = top + roi.height / camera.fy;
    outward_ = {
        Eigen::Vector3d(-1, 0, left).normalized(), Eigen::Vector3d(1, 0, -right).normalized(),
        Eigen::Vector3d(0, -1, top).normalized(), Eigen::Vector3d(0, 1, -bottom).normalized()};
  }
  bool sees(const mjvGeom& geom) const {
    const Eigen::Vector3d p_C = X_CW_ * Eigen::Vector3d(geom.pos[0], geom.pos[1], geom.pos[2]);
    const Hull hull = hull_of(geom);
    const Eigen::Vector3d half_axis_C = X_CW_.linear() * hull.half_axis;
    return std::all_of(outward_.begin(), outward_.end(), [&](const Eigen::Vector3d& n) {
      return n.dot(p_C) - std::abs(n.dot(half_axis_C)) < hull.radius;
    });
  }

 private:
  Eigen::Isometry3d X_CW_;
  std::array<Eigen::Vector3d, 4> outward_;
};

/// A MuJoCo context whose off-screen buffer has a given size.
class Buffer {
 public:
  Buffer(mjModel& model, int width, int height) {
    model.vis.global.offwidth = width;
    model.vis.global.offheight = height;
    mjr_defaultContext(&context_);
    mjr_makeContext(&model, &context_, mjFONTSCALE_50);
    mjr_setBuffer(mjFB_OFFSCREEN, &context_);
    if (context_.currentBuffer != mjFB_OFFSCREEN) {
      throw std::runtime_error("virtual cameras: the OSMesa context has no off-screen buffer");
    }
  }
  ~Buffer() { mjr_freeContext(&context_); }
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;

  void render(mjvScene& scene, cv::Mat& image) {
    mjr_setBuffer(mjFB_OFFSCREEN, &context_);
    const mjrRect view{0, 0, image.cols, image.rows};
    mjr_render(view, &scene, &context_);
    mjr_readPixels(image.data, nullptr, view, &context_);
  }

 private:
  mjrContext context_;
};

plant::SceneParameters scene_of(const plant::World& world) {
  plant::SceneParameters scene;
  scene.world = world;
  scene.offscreen_width = 16;
  scene.offscreen_height = 16;
  scene.offscreen_samples = 0;
  for (const plant::ObjectParameters& object : world.objects) {
    for (const scene::Tag& tag : object.object.tags)
      scene.tag_pictures.push_back(tag_picture(tag.id));
  }
  return scene;
}

}  // namespace

struct VirtualCameras::Implementation {
  class View : public Camera {
   public:
    View(Implementation& owner, const CameraModel& believed, const CameraModel& real)
        : owner_(owner), model_(believed), real_(real) {}
    const CameraModel& model() const override { return model_; }
    bool grab(std::int64_t at_ns, const Roi& roi, cv::Mat& image) override {
      return owner_.grab(real_, at_ns, roi, image);
    }

   private:
    Implementation& owner_;
    CameraModel model_, real_;
  };

  Implementation(const plant::World& world, const Parameters& parameters, std::uint64_t seed)
      : pixel_noise(parameters.pixel_noise), random(seed) {
    setenv("LP_NUM_THREADS", "0", 0);
    show_osmesa_to_mujoco();
    gl.reset(OSMesaCreateContextExt(OSMESA_RGBA, 24, 8, 0, nullptr));
    window.resize(4 * kWindow * kWindow);
    if (!gl || OSMesaMakeCurrent(gl.get(), window.data(), GL_UNSIGNED_BYTE, kWindow, kWindow) ==
                   GL_FALSE) {
      throw std::runtime_error("virtual cameras: no OSMesa context");
    }
    model = plant::build_model(scene_of(world));
    data.reset(mj_makeData(model.get()));
    if (parameters.colours == ObjectColours::kSame) paint_all_alike();
    base::Random calibration(seed ^ kCalibrationStream);
    int search_width = 1, search_height = 1;
    for (const CameraParameters& camera : parameters.cameras) {
      Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
      X_WC.linear() = camera.R_WC;
      X_WC.translation() = camera.p_WC;
      const CameraModel believed = centred_camera(camera.width, camera.height, camera.fovy, X_WC);
      CameraModel real = believed;
      real.X_WC = X_WC * calibration_error(parameters.calibration_error, calibration);
      views.push_back(std::make_unique<View>(*this, believed, real));
      cameras.push_back(views.back().get());
      search_width = std::max(search_width, camera.width / parameters.detector.search_binning);
      search_height = std::max(search_height, camera.height / parameters.detector.search_binning);
    }
    small_side = std::max(parameters.detector.roi, parameters.tags ? parameters.tags->region : 0);
    small = std::make_unique<Buffer>(*model, small_side, small_side);
    large_width = std::max(search_width, small_side);
    large_height = std::max(search_height, small_side);
    large = std::make_unique<Buffer>(*model, large_width, large_height);

    mjv_defaultOption(&option);
    std::fill(std::begin(option.geomgroup), std::end(option.geomgroup), mjtByte{0});
    option.geomgroup[plant::kGroupWorld] = 1;
    option.geomgroup[plant::kGroupArmPrimitives] = 1;
    std::fill(std::begin(option.sitegroup), std::end(option.sitegroup), mjtByte{0});
    mjv_defaultScene(&scene);
    mjv_makeScene(model.get(), &scene, kMaxGeoms);
    mjv_defaultFreeCamera(model.get(), &free_camera);
  }

  static Eigen::Isometry3d calibration_error(const CalibrationError& error, base::Random& random) {
    const auto draw = [&](double sigma) {
      const double x = random.normal(), y = random.normal(), z = random.normal();
      return Eigen::Vector3d(sigma * x, sigma * y, sigma * z);
    };
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.translation() = draw(error.position);
    X.linear() = integrate_rotation(Eigen::Quaterniond::Identity(), draw(error.angle), 1.0)
                     .toRotationMatrix();
    return X;
  }

  void paint_all_alike() {
    for (int geom = 0; geom < model->ngeom; ++geom) {
      const int joint = model->body_jntadr[model->geom_bodyid[geom]];
      if (joint < 0 || model->jnt_type[joint] != mjJNT_FREE) continue;
      Eigen::Map<Eigen::Vector3f>(model->geom_rgba + 4 * geom) =
          plant::kObjectColours[0].cast<float>();
    }
  }

  ~Implementation() {
    mjv_freeScene(&scene);
    small.reset();
    large.reset();
  }

  void expose(const ScenePose& pose) {
    if (static_cast<int>(7 * pose.X_WB.size()) != model->nq - plant::kJoints) {
      throw std::invalid_argument(
          "virtual cameras: the scene has another number of objects than the scenario");
    }
    exposure_ns = pose.exposure_ns;
    std::copy(pose.q.begin(), pose.q.end(), data->qpos);
    mjtNum* qpos = data->qpos + plant::kJoints;
    for (const Eigen::Isometry3d& X_WB : pose.X_WB) {
      const Eigen::Quaterniond q(X_WB.linear());
      Eigen::Map<Eigen::Vector3d>(qpos, 3) = X_WB.translation();
      Eigen::Map<Eigen::Vector4d>(qpos + 3, 4) << q.w(), q.x(), q.y(), q.z();
      qpos += 7;
    }
    mj_kinematics(model.get(), data.get());
    mj_comPos(model.get(), data.get());
    mj_camlight(model.get(), data.get());
    mjv_updateScene(model.get(), data.get(), &option, nullptr, &free_camera, mjCAT_ALL, &scene);
    geoms.assign(scene.geoms, scene.geoms + scene.ngeom);
    // the cameras are used for geometry, not for looks
    std::fill(std::begin(scene.flags), std::end(scene.flags), mjtByte{0});
  }

  bool grab(const CameraModel& camera, std::int64_t wanted_ns, const Roi& roi, cv::Mat& image) {
    if (wanted_ns != exposure_ns) return false;
    const int width = roi.width / roi.binning, height = roi.height / roi.binning;
    if (width > large_width || height > large_height) return false;
    // the frustum of the region alone: off the optical axis, its middle is where the region's
    // middle is
    const double scale_x = kNear / camera.fx, scale_y = kNear / camera.fy;
    mjvGLCamera& view = scene.camera[0];
    const Eigen::Vector3d p = camera.X_WC.translation();
    const Eigen::Vector3d forward = camera.X_WC.linear().col(2), up = -camera.X_WC.linear().col(1);
    for (int i = 0; i < 3; ++i) {
      view.pos[i] = static_cast<float>(p[i]);
      view.forward[i] = static_cast<float>(forward[i]);
      view.up[i] = static_cast<float>(up[i]);
    }
    view.frustum_center = static_cast<float>(scale_x * (roi.x - 0.5 + 0.5 * roi.width - camera.cx));
    view.frustum_top = static_cast<float>(-scale_y * (roi.y - 0.5 - camera.cy));
    view.frustum_bottom = static_cast<float>(-scale_y * (roi.y - 0.5 + roi.height - camera.cy));
    view.frustum_near = kNear;
    view.frustum_far = kFar;
    scene.camera[1] = view;

    // what is not in the picture still costs its triangles: half of the time of a small region
    const Pyramid pyramid(camera, roi);
    scene.ngeom = 0;
    for (const mjvGeom& geom : geoms) {
      if (pyramid.sees(geom)) scene.geoms[scene.ngeom++] = geom;
    }

    flipped.create(height, width, CV_8UC3);
    Buffer& buffer = width <= small_side && height <= small_side ? *small : *large;
    buffer.render(scene, flipped);
    cv::flip(flipped, image, 0);
    if (pixel_noise > 0.0) add_noise(image);
    return true;
  }

  /// The sum of four bytes is nearly normal, and no byte of an image shows tails beyond 3.5 of its
  /// standard deviations. A true normal number would cost more than the picture.
  void add_noise(cv::Mat& image) {
    constexpr int kBytes = 4;
    constexpr double kMean = 0.5 * 255.0 * kBytes;
    const double scale = pixel_noise / std::sqrt(kBytes * (256.0 * 256.0 - 1.0) / 12.0);
    std::uint64_t bits = 0;
    int left = 0;  // draws that are still in bits
    for (int row = 0; row < image.rows; ++row) {
      auto* pixel = image.ptr<std::uint8_t>(row);
      for (int k = 0; k < 3 * image.cols; ++k) {
        if (left-- == 0) {
          bits = random();
          left = 1;
        }
        const std::uint64_t sum =
            (bits & 255) + (bits >> 8 & 255) + (bits >> 16 & 255) + (bits >> 24 & 255);
        bits >>= 8 * kBytes;
        pixel[k] =
            cv::saturate_cast<std::uint8_t>(pixel[k] + scale * (static_cast<double>(sum) - kMean));
      }
    }
  }

  static constexpr int kWindow = 16;  // OSMesa wants a window; nothing is drawn there
  std::unique_ptr<osmesa_context, OsMesaDeleter> gl;
  std::vector<unsigned char> window;
  plant::Model model;
  plant::Data data;
  std::unique_ptr<Buffer> small, large;
  int small_side = 0, large_width = 0, large_height = 0;  // [px]
  mjvOption option;
  mjvScene scene;
  std::vector<mjvGeom> geoms;  // of the exposure
  mjvCamera free_camera;
  std::vector<std::unique_ptr<View>> views;
  std::vector<Camera*> cameras;
  std::int64_t exposure_ns = -1;
  double pixel_noise;
  std::mt19937_64 random;
  cv::Mat flipped;
};

VirtualCameras::VirtualCameras(const plant::World& world, const Parameters& parameters,
                               std::uint64_t seed)
    : implementation_(std::make_unique<Implementation>(world, parameters, seed)) {}
VirtualCameras::~VirtualCameras() = default;
void VirtualCameras::expose(const ScenePose& pose) { implementation_->expose(pose); }
const std::vector<Camera*>& VirtualCameras::cameras() const { return implementation_->cameras; }

}  // namespace c3rt::vision
