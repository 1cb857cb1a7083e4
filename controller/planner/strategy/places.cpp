#include "controller/planner/strategy/places.hpp"

#include <algorithm>

namespace c3rt::planner {
namespace {

constexpr std::size_t kMost = 64;        // places of a kind
constexpr double kBesideFailed = 0.015;  // [m]

}  // namespace

Places::Places(const SamplingParameters& parameters)
    : moved_(parameters.valid_moved), turned_(parameters.valid_turned) {
  good_.reserve(kMost);
  failed_.reserve(kMost);
}

void Places::clear() noexcept {
  good_.clear();
  failed_.clear();
  seen_.reset();
}

void Places::look(const scene::Body& body) noexcept {
  if (seen_) {
    const Eigen::Quaterniond now = body.q_WB, then = seen_->q_WB;
    if ((body.p_WB - seen_->p_WB).head<2>().norm() <= moved_ &&
        now.angularDistance(then) <= turned_)
      return;
  }
  clear();
  seen_ = body;
}

void Places::add(const Place& place) {
  if (place.worth.gain() <= 0.0) return;
  for (const Eigen::Vector3d& failed : failed_) {
    if ((failed - place.p_WE).norm() < kBesideFailed) return;
  }
  if (good_.size() == kMost) {
    const auto worst = std::min_element(
        good_.begin(), good_.end(),
        [](const auto& a, const auto& b) { return a.worth.gain() < b.worth.gain(); });
    if (worst->worth.gain() >= place.worth.gain()) return;
    good_.erase(worst);
  }
  good_.push_back(place);
}

void Places::fail(const Eigen::Vector3d& p_WE) {
  if (failed_.size() == kMost) failed_.erase(failed_.begin());
  failed_.push_back(p_WE);
  good_.erase(std::remove_if(
                  good_.begin(), good_.end(),
                  [&](const Place& place) { return (place.p_WE - p_WE).norm() < kBesideFailed; }),
              good_.end());
}

const Place* Places::best(const Eigen::Vector3d& from, double apart) const noexcept {
  const Place* best = nullptr;
  for (const Place& place : good_) {
    if ((place.p_WE - from).norm() < apart) continue;
    if (best == nullptr || place.worth.gain() > best->worth.gain()) best = &place;
  }
  return best;
}

bool worth_leaving(const SamplingParameters& parameters, const Worth& here,
                   const Worth& there) noexcept {
  return there.gain() >
         parameters.better * std::max(0.0, here.gain()) + parameters.margin * there.still;
}

}  // namespace c3rt::planner
