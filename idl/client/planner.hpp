#pragma once
// A planner of one's own in the place of c3rt-planner: a class with one method.
#include <memory>
#include <string>
#include <vector>

#include "idl/client/motion.hpp"
#include "idl/client/process.hpp"

namespace c3rt::client {

struct PlannerSettings {
  double rate = 100.0;     // plans a second, 1 to 1000 [Hz]
  double delay = 0.0075;   // a plan takes effect so long after the state that it was made from [s]
  double valid_for = 0.1;  // after that the arm holds; at most 10 [s]
};

/// After `c3rt stop` the arm is held and plan() is not called.
class Planner : public Process {
 public:
  /// @throws std::invalid_argument naming the setting
  explicit Planner(const PlannerSettings& settings = {});
  ~Planner() override;

  /// Once a period. In lockstep it must depend on nothing but what it is given, so that the same
  /// run gives the same bits. What it throws ends the process, as FAILED on service/status.
  virtual Motion plan(const Situation& now) = 0;
  /// A client's task. @throws std::invalid_argument saying why it is not taken; here none is
  virtual void target(const std::string& kind, const std::vector<Parameter>& parameters);

 private:
  class Planning;
  std::unique_ptr<Part> take_part(const Place& place) final;
  const PlannerSettings settings_;
};

}  // namespace c3rt::client
