#pragma once
// The impedance controller on the types of the wire: newest state and plan in, command out, once
// per cycle. No bus, no clock, no thread: servo.hpp has those.
#include <cstdint>

#include "controller/impedance/controller.hpp"
#include "idl/topics.hpp"

namespace c3rt::impedance {

class Node {
 public:
  struct Input {
    // what has come since the last step; nullptr: nothing
    const wire::RobotState* state = nullptr;
    const wire::Plan* plan = nullptr;
    bool stop = false, recover = false;  // a person asks
    bool spoilt = false;                 // a fault: the command shall not be finite
  };
  struct Output {
    bool commands = false;  // false: nothing is sent
    wire::RobotCommand command{};
    impedance::Output control{};  // what the command was made of
    bool robot_moves = false, standing = false;
  };

  Node(const Parameters& parameters, model::Arm arm);

  /// Valid until the next step. RT: no heap, no lock, no throw.
  const Output& step(std::int64_t now_ns, const Input& in) noexcept;
  const Output& output() const noexcept { return output_; }  // of the last step

 private:
  void fill_command() noexcept;

  Controller controller_;
  impedance::Input input_;
  std::int32_t robot_ = 0;      // of the newest state
  wire::Origin plan_origin_{};  // of the newest plan, with its own stamp
  Output output_;
};

}  // namespace c3rt::impedance
