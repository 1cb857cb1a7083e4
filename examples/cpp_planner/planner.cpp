// A planner of one's own in C++: it rolls the ball along a line from above, with motions of 16
// knots, 20 times a second (docs/clients.md). Run with examples/python_planner/roll.yaml.
#include "idl/client/planner.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

namespace {

using namespace c3rt::client;

constexpr double kTable = -0.0245, kBall = 0.0315, kTip = 0.0195;  // height, radii [m]
constexpr double kPress = 0.002;            // so far below the contact the tip is asked to be [m]
constexpr double kLift = 0.03;              // above the contact, on the way back [m]
constexpr double kBack = 0.5, kRoll = 0.7;  // times of the way back and of a stroke [s]
constexpr double kReach = 0.018;  // the contact is at most so far beside the ball's top [m]

/// From 0 to 1 within that time, at rest at both ends.
double smooth(double time, double duration) {
  const double s = std::clamp(time / duration, 0.0, 1.0);
  return s * s * s * (10.0 + s * (6.0 * s - 15.0));
}

/// Behind the ball, down, and over it: what rolls without slip below and above moves half as far.
class Roller : public Planner {
 public:
  Roller() : Planner({20.0, 0.0075, 0.5}) {}

  Motion plan(const Situation& now) override {
    const auto ball = now.objects.find(0);
    if (ball == now.objects.end()) return {};
    const bool first = !from_;
    if (first || now.time - began_ >= kBack + kRoll) {  // the next stroke
      phase_ = first ? "approach" : "roll";
      began_ = now.time;
      from_ = now.effector.p;
      ball_ = ball->second.p;
    } else if (now.time - began_ < kBack) {
      ball_ = ball->second.p;
    } else {
      phase_ = "roll";
    }
    Motion motion;
    motion.phase = phase_;
    for (int i = 0; i < 16; ++i) {
      const double after = 0.05 * i, time = now.time - began_ + after;
      Knot knot{where(time), {}, after};
      const Vector before = where(time - 1e-4), next = where(time + 1e-4);
      for (std::size_t k = 0; k < 3; ++k) knot.v[k] = (next[k] - before[k]) / 2e-4;
      motion.knots.push_back(knot);
    }
    return motion;
  }

 private:
  Vector where(double time) const {
    const double beside = kReach * (1.0 - 2.0 * smooth(time - kBack, kRoll));  // of the ball's top
    const double ball_y = ball_[1] - (kReach - beside);
    const double contact = kTable + kBall + std::sqrt(std::pow(kBall + kTip, 2) - beside * beside);
    const double down = smooth(time - 0.6 * kBack, 0.4 * kBack);
    const double over = smooth(time - 0.2 * kBack, 0.5 * kBack), up = smooth(time, 0.4 * kBack);
    const double above = contact + kLift;
    return {(*from_)[0] + over * (ball_[0] - (*from_)[0]),
            (*from_)[1] + over * (ball_y + beside - (*from_)[1]),
            (*from_)[2] + up * (above - (*from_)[2]) - down * (kLift + kPress)};
  }

  double began_ = 0.0;
  std::string phase_;
  std::optional<Vector> from_;  // the end effector at the beginning of the stroke
  Vector ball_{};
};

}  // namespace

int main(int argc, char** argv) { return Roller().main(argc, argv); }
