#include "idl/faults.hpp"

#include <cmath>
#include <limits>

#include <catch2/catch.hpp>

using namespace c3rt::wire;
using Catch::Contains;

namespace {

const double kNan = std::numeric_limits<double>::quiet_NaN();
const double kInfinity = std::numeric_limits<double>::infinity();
const FaultScope kScope{{0.132, 0.132}, 3};

FaultInject fault(Process process, c3rt_v2_FaultKind kind, double duration = 1.0, int index = 0) {
  FaultInject sample{};
  sample.process = process;
  sample.kind = kind;
  sample.duration_s = duration;
  sample.index = index;
  return sample;
}

FaultInject push(double x, double y, double z, int object = 0) {
  FaultInject sample = fault(c3rt_v2_PROCESS_PLANT, c3rt_v2_FAULT_PUSH_OBJECT, 0.0, object);
  sample.value[0] = x;
  sample.value[1] = y;
  sample.value[2] = z;
  return sample;
}

}  // namespace

TEST_CASE("faults: a push is of finite numbers, on a ball that is there, and no throw") {
  CHECK(refusal(push(0.005, 0.0, 0.0), kScope).empty());
  CHECK(refusal(push(0.0, -0.3, 0.0, 1), kScope).empty());
  for (const double bad : {kNan, kInfinity, 1e300, -1e300, 0.5}) {
    CAPTURE(bad);
    CHECK_FALSE(refusal(push(bad, 0.0, 0.0), kScope).empty());
    CHECK_FALSE(refusal(push(0.0, 0.0, bad), kScope).empty());
  }
  CHECK_THAT(refusal(push(1e300, 1e300, 0.0), kScope), Contains("expected an impulse"));
  CHECK_THAT(
      refusal(push(0.5, 0.0, 0.0), kScope),
      Contains("expected an impulse of at most 0.396 N s, which gives object 0 of 0.132 kg 3 "
               "m/s, got 0.5"));
  CHECK_THAT(refusal(push(0.01, 0.0, 0.0, 3), kScope),
             Contains("expected an object from 0 to 1, got 3"));
  CHECK_THAT(refusal(push(0.01, 0.0, 0.0, -1), kScope), Contains("got -1"));
}

TEST_CASE("faults: what lasts has a duration that ends") {
  for (const auto kind : {c3rt_v2_FAULT_STALL, c3rt_v2_FAULT_NAN, c3rt_v2_FAULT_DROP_COMMANDS}) {
    CHECK(refusal(fault(c3rt_v2_PROCESS_PLANT, kind), kScope).empty());
    for (const double bad : {kNan, kInfinity, -kInfinity, 0.0, -1.0, 1e6}) {
      CAPTURE(bad, kind);
      CHECK_THAT(refusal(fault(c3rt_v2_PROCESS_PLANT, kind, bad), kScope),
                 Contains("expected a duration of more than 0 and at most 3600 s, got"));
    }
  }
  CHECK(refusal(fault(c3rt_v2_PROCESS_PLANT, c3rt_v2_FAULT_NONE, kNan), kScope).empty());
}

TEST_CASE("faults: a camera is one that the scenario has") {
  const auto freeze = [](int camera, int cameras) {
    return refusal(fault(c3rt_v2_PROCESS_VISION, c3rt_v2_FAULT_FREEZE_CAMERA, 1.0, camera),
                   {{}, cameras});
  };
  CHECK(freeze(2, 3).empty());
  CHECK_THAT(freeze(99, 3), Contains("expected a camera from 0 to 2, got 99"));
  CHECK_THAT(freeze(-1, 3), Contains("got -1"));
  CHECK_THAT(freeze(0, 0), Contains("emulates"));
  CHECK(freeze(5, -1).empty());  // whose cameras are not known
  CHECK_FALSE(freeze(-1, -1).empty());
}

TEST_CASE("faults: each process has its own kinds, and others are refused by name") {
  CHECK_THAT(refusal(fault(c3rt_v2_PROCESS_PLANNER, c3rt_v2_FAULT_PUSH_OBJECT), kScope),
             Contains("expected none, stall or nan of planner, got push-object"));
  CHECK_THAT(refusal(fault(c3rt_v2_PROCESS_PLANT, c3rt_v2_FAULT_LOSE_OBJECT), kScope),
             Contains("push-object, drop-commands") && Contains("got lose-object"));
  CHECK_FALSE(
      refusal(fault(c3rt_v2_PROCESS_PLANT, static_cast<c3rt_v2_FaultKind>(7)), kScope).empty());
  CHECK_FALSE(refusal(fault(c3rt_v2_PROCESS_RECORDER, c3rt_v2_FAULT_STALL), kScope).empty());
}
