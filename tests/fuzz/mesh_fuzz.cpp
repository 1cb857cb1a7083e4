// The reader of meshes behind `c3rt object add`: any text, as each of the two formats, gives an
// Error or triangles whose corners exist; and what is made of them is finite, or an Error.
#include <cstddef>
#include <cstdint>
#include <string>

#include "cli/mesh/mesh.hpp"
#include "tests/fuzz/promise.hpp"

namespace {

using namespace c3rt::cli;

void look(const std::string& text, const std::string& file) try {
  mesh::Triangles triangles = mesh::parse(text, file);
  for (const Eigen::Vector3i& corners : triangles.triangles)
    require(
        corners.minCoeff() >= 0 && corners.maxCoeff() < static_cast<int>(triangles.points.size()),
        "every corner is a point");
  for (const Eigen::Vector3d& point : triangles.points)
    require(point.allFinite(), "every point is finite");
  if (triangles.triangles.size() > 200) return;
  triangles = mesh::welded(triangles);
  (void)mesh::open_edges(triangles);
  (void)mesh::turn_outwards(triangles);
  for (const mesh::Triangles& part : mesh::components(triangles)) {
    const mesh::Solid solid = mesh::solid_of(part);
    require(solid.volume > 0.0 && solid.com.allFinite() && solid.inertia.allFinite(),
            "a solid has a volume");
    (void)mesh::to_obj(mesh::hull_of(part, 16));
  }
} catch (const mesh::Error&) {
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  look(text, "fuzz.obj");
  look(text, "fuzz.stl");
  return 0;
}
