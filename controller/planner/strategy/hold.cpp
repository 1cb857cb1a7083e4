#include "controller/planner/strategy/hold.hpp"

#include "controller/planner/strategy/approach.hpp"

namespace c3rt::planner {
namespace {

class Hold final : public Strategy {
 public:
  explicit Hold(const Parameters& parameters)
      : way_(parameters.approach, parameters.geometry.table_height) {}

  void reset() override { decision_ = {}; }

  const Decision& decide(const Situation& now, C3Controller&) override {
    const Input& input = *now.input;
    const bool holds = now.available.state();
    const bool begins = decision_.mode != Mode::kHold || now.interrupted;
    decision_.mode = holds ? Mode::kHold : Mode::kWait;
    decision_.cause = Cause::kAsked;
    if (!holds) return decision_;
    if (begins) way_.begin(input.effector.p_WE);
    way_.out_of_the_way({input.now, now.period, input.effector.p_WE, input.robot_follows});
    decision_.p_WE = way_.reference();
    return decision_;
  }

 private:
  Approach way_;
  Decision decision_;
};

}  // namespace

std::unique_ptr<Strategy> make_hold(const Parameters& parameters, C3Controller&) {
  return std::make_unique<Hold>(parameters);
}

}  // namespace c3rt::planner
