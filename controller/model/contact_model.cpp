#include "controller/model/contact_model.hpp"

namespace c3rt::model {

int LambdaLayout::edge_count() const noexcept {
  // Anitescu's contact without friction has one λ, along its normal
  return has_normal() || n_e_ > 0 ? n_e_ : 1;
}

int LambdaLayout::size() const noexcept { return n_c_ * ((has_normal() ? 2 : 0) + edge_count()); }

int LambdaLayout::edges(int contact) const noexcept {
  return size() - (n_c_ - contact) * edge_count();
}

Row LambdaLayout::row(int i) const noexcept {
  if (!has_normal() || i < n_c_) return Row::kCone;
  return i < edges(0) ? Row::kDistance : Row::kSlip;
}

lcs::Lcs to_lcs(ContactModel model, const ContactSystem& system, double dt) {
  return model == ContactModel::kStewartTrinkle ? stewart_trinkle(system, dt)
                                                : anitescu(system, dt);
}

void to_lcs(ContactModel model, const ContactSystem& system, double dt, LcsStorage& storage,
            lcs::Lcs& lcs) {
  if (model == ContactModel::kStewartTrinkle) {
    stewart_trinkle(system, dt, storage, lcs);
  } else {
    anitescu(system, dt, storage, lcs);
  }
}

double newtons(ContactModel model, double scale, double dt) noexcept {
  return model == ContactModel::kStewartTrinkle ? scale : scale / dt;
}

}  // namespace c3rt::model
