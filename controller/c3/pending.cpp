#include <stdexcept>

#include "controller/c3/qp.hpp"

namespace c3rt::c3 {
std::unique_ptr<QpStep> make_interior_point_qp(const Sizes&) {
  throw std::logic_error("interior point: not yet");
}
}  // namespace c3rt::c3
