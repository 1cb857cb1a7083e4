#include <stdexcept>

#include "controller/c3/projection.hpp"
#include "controller/c3/qp.hpp"

namespace c3rt::c3 {
std::unique_ptr<QpStep> make_interior_point_qp(const Sizes&) {
  throw std::logic_error("interior point: not yet");
}
std::unique_ptr<Projection> make_admm_projection(const Sizes&) {
  throw std::logic_error("ADMM projection: not yet");
}
std::unique_ptr<Projection> make_convex_projection(const Sizes&) {
  throw std::logic_error("convex projection: not yet");
}
}  // namespace c3rt::c3
