#include "controller/c3/load_settings.hpp"

namespace c3rt::c3 {

Settings load_settings(config::Section section) {
  Settings settings{};
  settings.admm_iterations = section.integer("admm_iterations", {1, 1000});
  settings.rho = section.number("rho", {1e-9, 1e9});
  settings.rho_scale = section.number("rho_scale", {1, 100});
  settings.qp = section.choice<QpBackend>("qp", {{"direct", QpBackend::kDirect},
                                                 {"interior_point", QpBackend::kInteriorPoint},
                                                 {"osqp", QpBackend::kOsqp}});
  settings.projection =
      section.choice<ProjectionKind>("projection", {{"miqp", ProjectionKind::kMiqp},
                                                    {"lcp", ProjectionKind::kLcp},
                                                    {"admm", ProjectionKind::kAdmm},
                                                    {"convex", ProjectionKind::kConvex},
                                                    {"plus", ProjectionKind::kPlus}});
  settings.max_nodes = section.integer("max_nodes", {1, 1e6});
  config::Section osqp = section.section("osqp");
  settings.osqp.max_iterations = osqp.integer("max_iterations", {1, 1e6});
  settings.osqp.eps = osqp.number("eps", {1e-12, 1});
  settings.osqp.rho = osqp.number("rho", {1e-9, 1e9});
  settings.osqp.adaptive_rho_interval = osqp.integer("adaptive_rho_interval", {0, 1e6});
  settings.osqp.polish = osqp.boolean("polish");
  return settings;
}

}  // namespace c3rt::c3
