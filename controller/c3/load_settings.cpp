#include "controller/c3/load_settings.hpp"

#include <string>
#include <vector>

#include "controller/c3/projection/registry.hpp"

namespace c3rt::c3 {
namespace {

OsqpSettings load_osqp(config::Section section) {
  OsqpSettings osqp{};
  osqp.max_iterations = section.integer("max_iterations", {1, 1e6});
  osqp.eps = section.number("eps", {1e-12, 1});
  osqp.rho = section.number("rho", {1e-9, 1e9});
  osqp.adaptive_rho_interval = section.integer("adaptive_rho_interval", {0, 1e6});
  osqp.polish = section.boolean("polish");
  return osqp;
}

}  // namespace

Settings load_settings(config::Section section) {
  Settings settings{};
  settings.admm_iterations = section.integer("admm_iterations", {1, 1000});
  settings.rho = section.number("rho", {1e-9, 1e9});
  settings.rho_scale = section.number("rho_scale", {1, 100});
  settings.qp = section.choice<QpBackend>("qp", {{"direct", QpBackend::kDirect},
                                                 {"interior_point", QpBackend::kInteriorPoint},
                                                 {"osqp", QpBackend::kOsqp}});
  std::vector<std::string> projections;
  for (const auto type : kProjectionTypes) projections.emplace_back(type().key);
  settings.projection = kProjectionTypes[section.choice("projection", projections)]().kind;
  const ProjectionType& type = projection_type(settings.projection);
  settings.max_nodes =
      section.given("max_nodes", type.has_nodes, std::string("projection ") + type.key)
          ? section.integer("max_nodes", {1, 1e6})
          : 1;
  settings.polish = section.integer("polish", {0, 10000}, 0);
  if (section.given("osqp", settings.qp == QpBackend::kOsqp, "qp osqp"))
    settings.osqp = load_osqp(section.section("osqp"));
  return settings;
}

}  // namespace c3rt::c3
