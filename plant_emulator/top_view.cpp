#include "plant_emulator/top_view.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace c3rt::plant {
namespace {

constexpr double kAbove = 2.0;  // where the rays begin, in W [m]
constexpr std::array<std::uint8_t, 3> kNothing{0, 0, 0}, kEffector{40, 40, 40};

std::array<std::uint8_t, 3> colour(const mjModel& model, int geom) {
  const int material = model.geom_matid[geom];
  const float* rgba = material >= 0 ? model.mat_rgba + 4 * material : model.geom_rgba + 4 * geom;
  std::array<std::uint8_t, 3> out{};
  for (std::size_t i = 0; i < 3; ++i)
    out[i] = static_cast<std::uint8_t>(std::clamp(rgba[i], 0.0F, 1.0F) * 255.0F);
  return out;
}

}  // namespace

std::vector<std::uint8_t> top_view(const Plant& plant, const Eigen::AlignedBox2d& of, int width,
                                   int height) {
  const mjModel& model = plant.model();
  const int sphere = mj_name2id(&model, mjOBJ_GEOM, "end_effector");
  const double radius = model.geom_size[3 * sphere];
  constexpr std::array<mjtByte, mjNGROUP> kShown{1};  // kGroupWorld alone
  const Eigen::Vector2d p_WE = plant.state().p_WE.head<2>();
  const Eigen::Vector2d pixel = of.sizes().cwiseQuotient(Eigen::Vector2d(height, width));
  std::vector<std::uint8_t> out;
  out.reserve(std::size_t{3} * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const Eigen::Vector2d at =
          of.max() - pixel.cwiseProduct(Eigen::Vector2d(row + 0.5, column + 0.5));
      const Eigen::Vector3d from(at.x(), at.y(), kAbove), down(0.0, 0.0, -1.0);
      int geom = -1;
      mj_ray(&model, &plant.data(), from.data(), down.data(), kShown.data(), 1,
             model.geom_bodyid[sphere], &geom);
      const bool on_effector = (at - p_WE).norm() <= radius;
      const auto seen = on_effector ? kEffector : geom >= 0 ? colour(model, geom) : kNothing;
      out.insert(out.end(), seen.begin(), seen.end());
    }
  }
  return out;
}

}  // namespace c3rt::plant
