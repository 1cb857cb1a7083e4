#include "controller/model/registry.hpp"

#include <stdexcept>

#include "controller/model/ball_model.hpp"
#include "controller/model/balls_model.hpp"
#include "controller/model/cart_pole.hpp"
#include "controller/model/finger_gaiting.hpp"
#include "controller/model/mechanism_model.hpp"
#include "controller/model/objects_model.hpp"
#include "controller/model/pivoting.hpp"
#include "controller/model/pushed_box.hpp"

namespace c3rt::model {

double ModelValues::operator[](const std::string& key) const {
  const auto found = values_.find(key);
  if (found == values_.end())
    throw std::out_of_range("planning model: expected a value of " + key + ", got none");
  return found->second;
}

const std::vector<ModelKind>& model_kinds() {
  static const std::vector<ModelKind> kinds{rolling_ball_kind(), rolling_balls_kind(),
                                            pushed_box_kind(), mjcf_kind()};
  return kinds;
}

const ModelKind& model_kind(const std::string& name) {
  std::string known;
  for (const ModelKind& kind : model_kinds()) {
    if (kind.name == name) return kind;
    known += (known.empty() ? "" : ", ") + kind.name;
  }
  throw std::invalid_argument("planning model: expected one of " + known + ", got \"" + name +
                              "\"");
}

const std::vector<SystemKind>& system_kinds() {
  static const std::vector<SystemKind> kinds{cart_pole_kind(), finger_gaiting_kind(),
                                             mechanism_kind(), pivoting_kind()};
  return kinds;
}

const ModelKind& default_model_kind(int bodies) {
  return model_kind(bodies == 1 ? "rolling_ball" : "rolling_balls");
}

}  // namespace c3rt::model
