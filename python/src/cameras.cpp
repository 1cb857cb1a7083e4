// The extension c3rt._cameras: what the cameras of a scenario see. It stands beside _core, as it
// needs OSMesa.
#include <algorithm>
#include <cstdint>
#include <exception>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/stl/vector.h>
#include <opencv2/core/mat.hpp>

#include "cli/paths.hpp"
#include "config/config_error.hpp"
#include "config/scenario.hpp"
#include "plant_emulator/start.hpp"
#include "python/src/arrays.hpp"
#include "vision/virtual_cameras.hpp"

namespace c3rt::python {
namespace {

using namespace nb::literals;

/// The least binning of both sides that makes a picture no wider than that.
int binning_for(const vision::CameraParameters& camera, int width) {
  int binning = 1;
  while (camera.width / binning > width || camera.width % binning != 0 ||
         camera.height % binning != 0) {
    if (++binning > std::min(camera.width, camera.height)) return 1;
  }
  return binning;
}

class Cameras {
 public:
  Cameras(const std::string& scenario, const std::vector<std::string>& overrides,
          std::uint64_t seed, int width) {
    if (width < 32 || width > 2048)
      throw std::invalid_argument("width: expected 32 to 2048 pixels, got " +
                                  std::to_string(width));
    const config::Scenario of =
        config::load_scenario(cli::scenario_path(scenario).string(), overrides);
    parameters_ = of.vision;
    if (parameters_.source != vision::SourceKind::kCameras) parameters_.cameras.clear();
    objects_ = of.plant.world.objects.size();
    if (parameters_.cameras.empty()) return;
    // the buffer is as large as the largest picture
    for (const vision::CameraParameters& camera : parameters_.cameras)
      binnings_.push_back(binning_for(camera, width));
    parameters_.detector.search_binning = *std::min_element(binnings_.begin(), binnings_.end());
    rig_ = std::make_unique<vision::VirtualCameras>(plant::drawn_table(of.plant.world, seed),
                                                    parameters_, seed);
  }

  std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const vision::CameraParameters& camera : parameters_.cameras) names.push_back(camera.name);
    return names;
  }

  /// (fx, fy, cx, cy, width, height) of a camera's full image, in pixels
  nb::tuple intrinsics(int camera) const {
    const vision::CameraModel& model = at(camera).model();
    return nb::make_tuple(model.fx, model.fy, model.cx, model.cy, model.width, model.height);
  }
  Eigen::MatrixXd pose(int camera) const { return at(camera).model().X_WC.matrix(); }

  void expose(const Eigen::VectorXd& q, const Eigen::MatrixXd& objects) {
    if (rig_ == nullptr) throw std::invalid_argument("expose: the scenario has no cameras");
    vision::ScenePose pose;
    pose.exposure_ns = ++exposures_;
    std::copy(q.begin(), q.end(), pose.q.begin());
    for (const auto& row : objects.rowwise()) {
      const Eigen::Quaterniond q_WB(row[3], row[4], row[5], row[6]);
      if (!(q_WB.norm() > 1e-9))
        throw std::invalid_argument("objects: expected quaternions w x y z, got zeros");
      Eigen::Isometry3d X_WB(q_WB.normalized());
      X_WB.translation() = row.head<3>();
      pose.X_WB.push_back(X_WB);
    }
    rig_->expose(pose);
  }

  nb::object picture(int camera) {
    vision::Camera& of = at(camera);
    if (exposures_ == 0) throw std::invalid_argument("picture: expected expose() before");
    const int binning = binnings_.at(static_cast<std::size_t>(camera));
    cv::Mat image;
    {
      const nb::gil_scoped_release others_run;
      if (!of.grab(exposures_, vision::full_roi(of.model(), binning), image))
        throw std::runtime_error("picture: the camera has no frame");
    }
    const auto height = static_cast<std::size_t>(image.rows),
               width = static_cast<std::size_t>(image.cols);
    auto pixels = std::make_unique<std::vector<std::uint8_t>>();
    pixels->reserve(height * width * 3);
    for (int row = 0; row < image.rows; ++row)
      pixels->insert(pixels->end(), image.ptr<std::uint8_t>(row),
                     image.ptr<std::uint8_t>(row) + 3 * width);
    std::uint8_t* data = pixels->data();
    const nb::capsule owner(pixels.release(), [](void* memory) noexcept {
      std::unique_ptr<std::vector<std::uint8_t>>(static_cast<std::vector<std::uint8_t>*>(memory))
          .reset();
    });
    return nb::cast(nb::ndarray<nb::numpy, std::uint8_t>(data, {height, width, 3}, owner));
  }

  std::size_t objects() const { return objects_; }

 private:
  vision::Camera& at(int camera) const {
    const int count = static_cast<int>(parameters_.cameras.size());
    if (camera < 0 || camera >= count)
      throw std::invalid_argument("camera: expected 0 to " + std::to_string(count - 1) + ", got " +
                                  std::to_string(camera));
    return *rig_->cameras()[static_cast<std::size_t>(camera)];
  }

  vision::Parameters parameters_;
  std::size_t objects_ = 0;
  std::vector<int> binnings_;  // by camera
  std::int64_t exposures_ = 0;
  std::unique_ptr<vision::VirtualCameras> rig_;
};

void bind_cameras(nb::module_& module) {
  module.doc() = "The virtual cameras of a scenario.";
  nb::register_exception_translator([](const std::exception_ptr& thrown, void* /*unused*/) {
    try {
      std::rethrow_exception(thrown);
    } catch (const config::ConfigError& error) {
      PyErr_SetString(PyExc_ValueError, error.what());
    } catch (const cli::UsageError& error) {
      PyErr_SetString(PyExc_ValueError, error.what());
    }
  });
  nb::class_<Cameras>(
      module, "Cameras",
      "What vision's virtual cameras see of a scene, for pictures. One thread makes it "
      "and uses it.")
      .def(nb::init<const std::string&, const std::vector<std::string>&, std::uint64_t, int>(),
           "scenario"_a, "overrides"_a = std::vector<std::string>(), "seed"_a = 1, "width"_a = 480,
           "seed: of the table, and of how far the cameras stand from where the scenario says. "
           "width: no picture is wider [px]. A scenario without cameras has no names.")
      .def_prop_ro("names", &Cameras::names, "The cameras, in the scenario's order.")
      .def("intrinsics", &Cameras::intrinsics, "camera"_a,
           nb::sig(
               "def intrinsics(self, camera: int) -> tuple[float, float, float, float, int, int]"),
           "fx, fy, cx, cy, width, height of the full image [px], as vision believes them")
      .def(
          "pose",
          [](const Cameras& self, int camera) {
            return copy_stages(self.pose(camera).transpose());
          },
          "camera"_a, nb::sig("def pose(self, camera: int) -> numpy.typing.NDArray[numpy.float64]"),
          "X_WC (4, 4), as vision believes it: x right, y down, z forward in the image")
      .def(
          "expose",
          [](Cameras& self, nb::handle q, nb::handle objects) {
            self.expose(vector(q, "q", 7),
                        matrix(objects, "objects", static_cast<Eigen::Index>(self.objects()), 7));
          },
          "q"_a, "objects"_a,
          nb::sig("def expose(self, q: numpy.typing.ArrayLike, objects: numpy.typing.ArrayLike) -> "
                  "None"),
          "q: (7,) of the joints [rad]; objects: (n, 7), position [m] and orientation w x y z")
      .def("picture", &Cameras::picture, "camera"_a,
           nb::sig("def picture(self, camera: int) -> numpy.typing.NDArray[numpy.uint8]"),
           "(height, width, 3) of the last exposure, with the scenario's noise of pixels.");
}

}  // namespace
}  // namespace c3rt::python

NB_MODULE(_cameras, module) { c3rt::python::bind_cameras(module); }
