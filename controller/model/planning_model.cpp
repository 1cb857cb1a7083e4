#include "controller/model/planning_model.hpp"

#include <algorithm>
#include <numeric>

#include "controller/model/contact_model.hpp"

namespace c3rt::model {

std::vector<std::string> Layout::weights() const {
  std::vector<std::string> names;
  for (const StateBlock& block : x) {
    if (!block.name.empty() && std::find(names.begin(), names.end(), block.name) == names.end())
      names.push_back(block.name);
  }
  return names;
}

std::vector<int> Layout::bodies(const std::string& weight) const {
  std::vector<int> result;
  for (const StateBlock& block : x) {
    if (block.name == weight && std::find(result.begin(), result.end(), block.body) == result.end())
      result.push_back(block.body);
  }
  return result;
}

std::vector<int> all_contacts(const Layout& layout) {
  std::vector<int> all(layout.contacts.size());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

Eigen::Vector3d force_on_end_effector(const Layout& layout, const ContactSystem& system,
                                      const Eigen::Ref<const Eigen::VectorXd>& lambda) {
  const LambdaLayout order(ContactModel::kStewartTrinkle, static_cast<int>(system.n_c()),
                           static_cast<int>(system.n_e()));
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  for (int i = 0; i < system.n_c(); ++i) {
    const auto on_effector = [&](const Eigen::MatrixXd& J, int row) -> Eigen::Vector3d {
      return J.block<1, 3>(row, layout.effector_v).transpose();
    };
    Eigen::Vector3d of_contact = on_effector(system.J_n, i) * lambda[order.normal(i)];
    for (int edge = 0; edge < system.n_e(); edge += 2) {
      const int at = order.edges(i) + edge;
      of_contact += on_effector(system.J_t, i * static_cast<int>(system.n_e()) + edge) *
                    (lambda[at] - lambda[at + 1]);
    }
    force += of_contact;
  }
  return force;
}

}  // namespace c3rt::model
