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
  seen_.fill(std::nullopt);
}

void Places::forget(int body) noexcept {
  const auto of_it = [&](const Place& place) { return place.body == body; };
  good_.erase(std::remove_if(good_.begin(), good_.end(), of_it), good_.end());
  failed_.erase(std::remove_if(failed_.begin(), failed_.end(), of_it), failed_.end());
}

void Places::look(int body, const scene::Body& now) noexcept {
  std::optional<scene::Body>& seen = seen_[static_cast<std::size_t>(body)];
  if (seen) {
    const Eigen::Quaterniond q_now = now.q_WB, q_then = seen->q_WB;
    if ((now.p_WB - seen->p_WB).head<2>().norm() <= moved_ &&
        q_now.angularDistance(q_then) <= turned_)
      return;
  }
  forget(body);
  seen = now;
}

void Places::add(const Place& place) {
  if (place.worth.gain() <= 0.0) return;
  for (const Place& failed : failed_) {
    if (failed.body == place.body && (failed.p_WE - place.p_WE).norm() < kBesideFailed) return;
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

void Places::fail(int body, const Eigen::Vector3d& p_WE) {
  if (failed_.size() == kMost) failed_.erase(failed_.begin());
  failed_.push_back({p_WE, {}, body});
  const auto beside = [&](const Place& place) {
    return place.body == body && (place.p_WE - p_WE).norm() < kBesideFailed;
  };
  good_.erase(std::remove_if(good_.begin(), good_.end(), beside), good_.end());
}

template <typename Counts>
const Place* Places::best_where(const Counts& counts) const noexcept {
  const Place* best = nullptr;
  for (const Place& place : good_) {
    if (!counts(place)) continue;
    if (best == nullptr || place.worth.gain() > best->worth.gain()) best = &place;
  }
  return best;
}

const Place* Places::best(const Eigen::Vector3d& from, double apart) const noexcept {
  return best_where([&](const Place& place) { return (place.p_WE - from).norm() >= apart; });
}

const Place* Places::best_of(int body, const Eigen::Vector3d& from, double apart) const noexcept {
  return best_where([&](const Place& place) {
    return place.body == body && (place.p_WE - from).norm() >= apart;
  });
}

bool worth_leaving(const SamplingParameters& parameters, const Worth& here,
                   const Worth& there) noexcept {
  return there.gain() >
         parameters.better * std::max(0.0, here.gain()) + parameters.margin * there.still;
}

}  // namespace c3rt::planner
