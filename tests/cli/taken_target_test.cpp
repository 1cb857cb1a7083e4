#include "cli/taken_target.hpp"

#include <catch2/catch.hpp>

using namespace c3rt;
using cli::TakenTarget;

namespace {

wire::TaskTarget asked(std::uint64_t id, double radius = 0.1) {
  wire::TaskTarget target{};
  target.request_id = id;
  target.parameters[0].values[0] = radius;
  return target;
}
wire::ServiceReply answer(std::uint64_t id, bool ok,
                          wire::Process process = c3rt_v2_PROCESS_PLANNER) {
  wire::ServiceReply reply{};
  reply.request_id = id;
  reply.process = process;
  reply.ok = ok;
  return reply;
}

}  // namespace

TEST_CASE("taken target: what the planner took, its answer before the target or after it") {
  TakenTarget targets;
  CHECK_FALSE(targets.target());
  targets.asked(asked(1));
  CHECK_FALSE(targets.target());
  targets.answered(answer(1, true));
  REQUIRE(targets.target());
  CHECK(targets.target()->request_id == 1);
  targets.answered(answer(2, true));
  CHECK(targets.target()->request_id == 1);
  targets.asked(asked(2));
  CHECK(targets.target()->request_id == 2);
}

TEST_CASE("taken target: what was refused, or answered by another process, is none") {
  TakenTarget targets;
  targets.asked(asked(1));
  targets.answered(answer(1, true));
  targets.asked(asked(2));
  targets.answered(answer(2, false));
  targets.answered(answer(3, false));
  targets.asked(asked(3));
  targets.asked(asked(4));
  targets.answered(answer(4, true, c3rt_v2_PROCESS_PLANT));
  CHECK(targets.target()->request_id == 1);
}

TEST_CASE("taken target: of two that wait for an answer it is the one answered last") {
  TakenTarget targets;
  targets.asked(asked(1));
  targets.asked(asked(2));
  targets.answered(answer(2, true));
  targets.answered(answer(1, true));
  CHECK(targets.target()->request_id == 1);
}

TEST_CASE("taken target: one that asks for no answer counts as taken, and no reply is its") {
  TakenTarget targets;
  targets.asked(asked(0, 0.08));
  REQUIRE(targets.target());
  CHECK(targets.target()->parameters[0].values[0] == 0.08);
  targets.asked(asked(1));
  targets.answered(answer(0, true));
  CHECK(targets.target()->request_id == 0);
}
