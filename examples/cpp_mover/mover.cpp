// A motion generator of one's own in C++: it turns the last joint by 0.3 rad within 0.8 s, says how
// far it came, and is still.
//
//   cpp_mover --clock lockstep &
//   c3rt up circle_slow --without impedance --clock lockstep
#include "idl/client/mover.hpp"

#include <algorithm>
#include <cstdio>
#include <optional>

namespace {

using namespace c3rt::client;

constexpr double kWay = 0.3;       // [rad]
constexpr double kDuration = 0.8;  // [s]
constexpr double kSettled = 0.1;   // after the motion's end [s]
constexpr int kJoint = 6;

class Turn final : public Mover {
 public:
  std::optional<Command> move(double time, const Effector& now) override {
    if (!start_) {
      if (!now.moves) return std::nullopt;
      start_ = time;
      q_ = now.q;
    }
    const double since = time - *start_;
    if (!finished_) {
      // from rest to rest, its acceleration without a jump
      const double s = std::min(since / kDuration, 1.0);
      JointPositions command{q_};
      command.q[kJoint] += kWay * s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
      command.finished = finished_ = s == 1.0;
      return command;
    }
    if (!told_ && since > kDuration + kSettled) {
      std::printf("turned by %.4f rad\n", now.q[kJoint] - q_[kJoint]);
      std::fflush(stdout);
      told_ = true;
    }
    return std::nullopt;
  }

 private:
  std::optional<double> start_;
  Joints q_{};
  bool finished_ = false, told_ = false;
};

}  // namespace

int main(int argc, char** argv) { return Turn().main(argc, argv); }
