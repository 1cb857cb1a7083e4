#pragma once
// Places that were tried while a body lay still, the good and the failed ones, and when one of them
// is worth to leave another for.
#include <optional>
#include <vector>

#include "controller/planner/parameters.hpp"
#include "controller/planner/strategy/candidate.hpp"
#include "controller/scene/scene.hpp"

namespace c3rt::planner {

struct Place {
  Eigen::Vector3d p_WE;  // [m]
  Worth worth;
};

class Places {
 public:
  explicit Places(const SamplingParameters& parameters);

  /// Forgets what was tried before the body moved, or was turned, too far for it to count.
  void look(const scene::Body& body) noexcept;
  void clear() noexcept;
  /// Of many the best are kept. One beside a place that failed is not.
  void add(const Place& place);
  /// Nothing came of this one.
  void fail(const Eigen::Vector3d& p_WE);

  /// That with the most gain, farther than `apart` from where the end effector is; none if there is
  /// none with any gain.
  const Place* best(const Eigen::Vector3d& from, double apart) const noexcept;
  int count() const noexcept { return static_cast<int>(good_.size()); }

 private:
  double moved_, turned_;
  std::optional<scene::Body> seen_;
  std::vector<Place> good_;
  std::vector<Eigen::Vector3d> failed_;
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
