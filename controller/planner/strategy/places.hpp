#pragma once
// Places that were tried while bodies lay still, the good and the failed ones, and when one of them
// is worth to leave another for.
#include <array>
#include <optional>
#include <vector>

#include "controller/planner/parameters.hpp"
#include "controller/planner/strategy/candidate.hpp"
#include "controller/scene/scene.hpp"

namespace c3rt::planner {

struct Place {
  Eigen::Vector3d p_WE;  // [m]
  Worth worth;
  int body = 0;  // beside which it is
};

class Places {
 public:
  explicit Places(const SamplingParameters& parameters);

  /// Forgets what was tried beside a body before it moved, or was turned, too far for it to count.
  void look(int body, const scene::Body& now) noexcept;
  void forget(int body) noexcept;
  void clear() noexcept;
  /// Of many the best are kept. One beside a place that failed is not.
  void add(const Place& place);
  /// Nothing came of this one.
  void fail(int body, const Eigen::Vector3d& p_WE);

  /// That with the most gain, farther than `apart` from where the end effector is; none if there is
  /// none with any gain.
  const Place* best(const Eigen::Vector3d& from, double apart) const noexcept;
  /// The same of one body.
  const Place* best_of(int body, const Eigen::Vector3d& from, double apart) const noexcept;
  int count() const noexcept { return static_cast<int>(good_.size()); }

 private:
  template <typename Counts>
  const Place* best_where(const Counts& counts) const noexcept;

  double moved_, turned_;
  std::array<std::optional<scene::Body>, scene::kMaxBodies> seen_;
  std::vector<Place> good_, failed_;
};

/// Whether to leave a place for a better one: the one gains more than the other by a factor, and by
/// a part of what there is to gain, since a way between them takes time.
bool worth_leaving(const SamplingParameters& parameters, const Worth& here,
                   const Worth& there) noexcept;

/// Whether a body comes nearer to its goal: what is left has to fall by a part within a time.
class Headway {
 public:
  Headway(double part, double time) : part_(part), time_(time) {}
  void begin(double now, double left) noexcept {
    since_ = now;
    left_ = left;
  }
  /// @return false where it has not fallen in time
  bool made(double now, double left) noexcept {
    if (left <= (1.0 - part_) * left_) begin(now, left);
    return now - since_ <= time_;
  }

 private:
  double part_, time_, since_ = 0.0, left_ = 0.0;
};

}  // namespace c3rt::planner
