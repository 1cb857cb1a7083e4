#include "plant_emulator/scene.hpp"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include <GL/osmesa.h>
#include <catch2/catch.hpp>
#include <opencv2/imgproc.hpp>

#include "controller/mjcf/object.hpp"
#include "plant_emulator/plant.hpp"
#include "tests/plant_emulator/parameters.hpp"

using namespace c3rt;
using namespace c3rt::plant;

namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 480;

/// A camera at `eye` that looks at `target`, with the image's top towards +z.
CameraPose look_at(const std::string& name, const Eigen::Vector3d& eye,
                   const Eigen::Vector3d& target) {
  const Eigen::Vector3d z = (eye - target).normalized();
  const Eigen::Vector3d x = Eigen::Vector3d::UnitZ().cross(z).normalized();
  Eigen::Matrix3d R_WC;
  R_WC << x, z.cross(x), z;
  return {name, eye, Eigen::Quaterniond(R_WC), 0.7};
}

SceneParameters scene_with_cameras(const std::string& meshes) {
  SceneParameters p = test_scene();
  const Eigen::Vector3d center(0.55, 0, 0);
  p.cameras = {look_at("front", {1.35, 0, 0.55}, center),
               look_at("left", {0.55, 0.8, 0.55}, center),
               look_at("right", {0.55, -0.8, 0.55}, center),
               look_at("overview", {1.5, 1.2, 0.9}, {0.3, 0, 0.3})};
  p.offscreen_width = kWidth;
  p.offscreen_height = kHeight;
  p.offscreen_samples = 4;
  p.mesh_directory = meshes;
  return p;
}

/// Renders off screen with OSMesa.
class Renderer {
 public:
  explicit Renderer(const mjModel& model) : model_(model), pixels_(4 * kWidth * kHeight) {
    context_ = OSMesaCreateContextExt(OSMESA_RGBA, 24, 8, 8, nullptr);
    REQUIRE(context_ != nullptr);
    REQUIRE(OSMesaMakeCurrent(context_, pixels_.data(), GL_UNSIGNED_BYTE, kWidth, kHeight) ==
            GL_TRUE);
    mjv_defaultScene(&scene_);
    mjv_makeScene(&model_, &scene_, 200);
    mjr_defaultContext(&gl_);
    mjr_makeContext(&model_, &gl_, mjFONTSCALE_50);
    mjr_setBuffer(mjFB_OFFSCREEN, &gl_);
    REQUIRE(gl_.currentBuffer == mjFB_OFFSCREEN);
  }
  ~Renderer() {
    mjr_freeContext(&gl_);
    mjv_freeScene(&scene_);
    OSMesaDestroyContext(context_);
  }
  cv::Mat render(mjData& data, const std::string& camera, GeomGroup arm) {
    mjvOption option;
    mjv_defaultOption(&option);
    for (mjtByte& group : option.geomgroup) group = 0;
    option.geomgroup[kGroupWorld] = option.geomgroup[arm] = 1;
    mjvCamera view;
    mjv_defaultCamera(&view);
    view.type = mjCAMERA_FIXED;
    view.fixedcamid = mj_name2id(&model_, mjOBJ_CAMERA, camera.c_str());
    REQUIRE(view.fixedcamid >= 0);
    mjv_updateScene(&model_, &data, &option, nullptr, &view, mjCAT_ALL, &scene_);
    const mjrRect whole{0, 0, kWidth, kHeight};
    mjr_render(whole, &scene_, &gl_);
    cv::Mat image(kHeight, kWidth, CV_8UC3);
    mjr_readPixels(image.data, nullptr, whole, &gl_);
    cv::flip(image, image, 0);  // OpenGL starts below
    cv::cvtColor(image, image, cv::COLOR_RGB2BGR);
    return image;
  }

 private:
  const mjModel& model_;
  std::vector<unsigned char> pixels_;
  OSMesaContext context_ = nullptr;
  mjvScene scene_{};
  mjrContext gl_{};
};

Data home(const mjModel& model) {
  Data data(mj_makeData(&model));
  Eigen::Map<Vector7d>(data->qpos) = test_parameters().initial_q;
  mj_forward(&model, data.get());
  return data;
}

/// Where the pinhole model sees a point of the world, in pixels from the upper left corner.
cv::Point2d project(const CameraPose& camera, const Eigen::Vector3d& p_W) {
  const Eigen::Vector3d p_C = camera.q_WC.inverse() * (p_W - camera.p_WC);
  const double focal = 0.5 * kHeight / std::tan(0.5 * camera.fovy);
  return {0.5 * kWidth - focal * p_C.x() / p_C.z(), 0.5 * kHeight + focal * p_C.y() / p_C.z()};
}

/// With C3RT_TEST_PICTURES set to a folder, a person can look at what the tests render.
void keep(const std::string& name, const cv::Mat& image) {
  const char* folder = std::getenv("C3RT_TEST_PICTURES");
  if (folder == nullptr) return;
  cv::Mat rgb;
  cv::cvtColor(image, rgb, cv::COLOR_BGR2RGB);
  std::ofstream file(std::string(folder) + "/" + name + ".ppm", std::ios::binary);
  file << "P6 " << kWidth << " " << kHeight << " 255\n";
  file.write(reinterpret_cast<const char*>(rgb.data),
             static_cast<std::streamsize>(rgb.total() * 3));
}

TEST_CASE(
    "each camera sees the ball where the pinhole model puts it, clear of the table in colour") {
  for (const std::string& meshes : {std::string(), installed_mesh_directory()}) {
    const SceneParameters parameters = scene_with_cameras(meshes);
    const Model model = build_model(parameters);
    const Data data = home(*model);
    Renderer renderer(*model);
    const GeomGroup arm = meshes.empty() ? kGroupArmPrimitives : kGroupArmMeshes;
    for (const CameraPose& camera : parameters.cameras) {
      const cv::Mat image = renderer.render(*data, camera.name, arm);
      keep(camera.name + (meshes.empty() ? "_primitives" : "_meshes"), image);
      cv::Mat hsv, orange;
      cv::cvtColor(image, hsv, cv::COLOR_BGR2HSV);
      cv::inRange(hsv, cv::Scalar(3, 150, 30), cv::Scalar(22, 255, 255), orange);
      const cv::Moments m = cv::moments(orange, true);
      CAPTURE(camera.name, meshes, m.m00);
      REQUIRE(m.m00 > 100);
      const cv::Point2d seen(m.m10 / m.m00, m.m01 / m.m00);
      const cv::Point2d expected = project(camera, object_start(parameters.world, 0).translation());
      CHECK(std::hypot(seen.x - expected.x, seen.y - expected.y) < 2.0);
    }
  }
}

TEST_CASE("a camera sees the T of a file where its parts are, and table in its hollows") {
  SceneParameters parameters = scene_with_cameras(installed_mesh_directory());
  parameters.cameras.push_back(look_at("above", {0.6, 0.3, 0.6}, {0.55, 0.25, 0.0}));
  ObjectParameters t{};
  t.object = mjcf::read_object(C3RT_SOURCE_DIRECTORY "/config/objects/t.xml").object;
  t.position = {0.55, 0.25};
  t.yaw = 0.6;
  parameters.world.objects = {t};
  const Model model = build_model(parameters);
  const Data data = home(*model);
  Renderer renderer(*model);
  const GeomGroup arm = parameters.mesh_directory.empty() ? kGroupArmPrimitives : kGroupArmMeshes;
  keep("t_overview", renderer.render(*data, "overview", arm));
  const cv::Mat image = renderer.render(*data, "above", arm);
  keep("t_above", image);
  cv::Mat hsv, orange;
  cv::cvtColor(image, hsv, cv::COLOR_BGR2HSV);
  cv::inRange(hsv, cv::Scalar(3, 150, 30), cv::Scalar(22, 255, 255), orange);
  const Eigen::Isometry3d X_WB = object_start(parameters.world, 0);
  const auto is_orange = [&](double x, double y) {
    // a point of the T's upper side, from the middle of its top in the file's axes
    const Eigen::Vector3d p_B =
        Eigen::Vector3d(x, y, 0.02) - Eigen::Vector3d(0.0, -0.08 * 0.24 / 0.56, 0.0);
    const cv::Point2d at = project(parameters.cameras.back(), X_WB * p_B);
    return orange.at<std::uint8_t>(static_cast<int>(std::lround(at.y)),
                                   static_cast<int>(std::lround(at.x))) > 0;
  };
  for (const auto& [x, y] : {std::pair(0.0, 0.0),
                             {0.07, 0.01},
                             {-0.07, -0.01},
                             {0.0, -0.13},
                             {0.01, -0.05},
                             {-0.01, -0.1}}) {
    CAPTURE(x, y);
    CHECK(is_orange(x, y));
  }
  for (const auto& [x, y] :
       {std::pair(0.06, -0.08), {-0.06, -0.08}, {0.05, -0.13}, {0.1, 0.0}, {0.0, 0.04}}) {
    CAPTURE(x, y);
    CHECK_FALSE(is_orange(x, y));
  }
}

TEST_CASE("eight objects have colours that a camera tells apart") {
  for (std::size_t i = 0; i < kObjectColours.size(); ++i) {
    const Eigen::Vector3d colour = kObjectColours[i];
    CHECK(colour.maxCoeff() - colour.minCoeff() > 0.5);
    const auto across_grey = [](const Eigen::Vector3d& c) {
      return Eigen::Vector3d(c - Eigen::Vector3d::Constant(c.mean()));
    };
    for (std::size_t j = 0; j < i; ++j) {
      const Eigen::Vector3d a = across_grey(colour), b = across_grey(kObjectColours[j]);
      CAPTURE(i, j);
      CHECK(a.dot(b) < 0.87 * a.norm() * b.norm());  // half a radian of hue
    }
  }
}

TEST_CASE("the meshes are there for looks and change nothing in the dynamics") {
  if (installed_mesh_directory().empty()) return;
  const Model plain = build_model(scene_with_cameras(""));
  const Model meshed = build_model(scene_with_cameras(installed_mesh_directory()));
  CHECK(meshed->nmesh == kJoints + 1);
  REQUIRE(plain->nbody == meshed->nbody);
  for (int i = 0; i < plain->nbody; ++i) CHECK(plain->body_mass[i] == meshed->body_mass[i]);
  CHECK(plain->npair == meshed->npair);
}

TEST_CASE("a scene that cannot be is refused by name") {
  SceneParameters p = test_scene();
  p.world.step = 0.002;
  CHECK_THROWS_WITH(build_model(p), Catch::Contains("step must be in (0, 0.001] s"));
  p = test_scene();
  p.world.objects.clear();
  CHECK_THROWS_WITH(build_model(p), Catch::Contains("1 to 8 objects"));
  p = test_scene();
  p.mesh_directory = "/nowhere";
  CHECK_THROWS_WITH(build_model(p), Catch::Contains("link0.stl"));
}

}  // namespace
