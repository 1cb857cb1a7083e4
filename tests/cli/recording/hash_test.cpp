#include "cli/recording/hash.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <catch2/catch.hpp>

#include "cli/recording/samples.hpp"
#include "idl/text.hpp"

namespace {

using namespace c3rt;
using namespace c3rt::cli;

wire::Plan plan() {
  wire::Plan sample{};
  sample.header = {7, 3, 1'000'000};
  sample.knot_count = 2;
  sample.knots[1].p_WE_m[2] = 0.5;
  sample.solve_time_s = 0.001;
  wire::set_text(sample.phase, "roll");
  return sample;
}

template <typename T>
std::uint64_t hash_of(const T& sample) {
  HashVisitor visitor;
  visit_sample(sample, visitor);
  return visitor.value();
}

}  // namespace

TEST_CASE("the hash sees every value that counts, the predicted horizon included") {
  const std::uint64_t reference = hash_of(plan());
  wire::Plan changed = plan();
  changed.knots[1].p_WE_m[2] = std::nextafter(0.5, 1.0);  // one bit
  REQUIRE(hash_of(changed) != reference);
  changed = plan();
  changed.header.time_ns += 1;
  REQUIRE(hash_of(changed) != reference);
  changed = plan();
  wire::set_text(changed.phase, "return");
  REQUIRE(hash_of(changed) != reference);
  wire::PlannerDebug debug{};
  const std::uint64_t horizon = hash_of(debug);
  debug.states[479] = 1e-300;
  REQUIRE(hash_of(debug) != horizon);
}

TEST_CASE("the hash does not see the session, what the machine measured, or what is not used") {
  const std::uint64_t reference = hash_of(plan());
  wire::Plan changed = plan();
  changed.header.session_id = 99;
  changed.solve_time_s = 0.7;
  changed.knots[2].p_WE_m[0] = 1.0;  // behind the last knot
  changed.phase[6] = 'x';            // behind the text's end
  REQUIRE(hash_of(changed) == reference);
}

TEST_CASE("the hash does not see the padding between the fields") {
  wire::RobotState zeros, ones;
  std::memset(&zeros, 0x00, sizeof zeros);
  std::memset(&ones, 0xff, sizeof ones);
  zeros = wire::RobotState{};
  const auto copy_fields = [](wire::RobotState& target) {
    target.robot = 0;
    target.header = {};
    for (double* values : {target.q_rad, target.dq_rad_per_s, target.tau_nm})
      std::fill(values, values + 7, 0.0);
    std::fill(target.p_WE_m, target.p_WE_m + 3, 0.0);
    std::fill(target.q_WE, target.q_WE + 4, 0.0);
    target.mode = c3rt_v2_ROBOT_IDLE;
    target.errors = 0;
    target.command_success_rate = 0.0;
    target.command_seq = 0;
    target.command_state_ns = 0;
  };
  copy_fields(zeros);
  copy_fields(ones);
  HashVisitor a, b;
  visit_sample(zeros, a);
  visit_sample(ones, b);
  REQUIRE(a.value() == b.value());
}

TEST_CASE("the hash of a run without motions is that of the seven streams of version 0.12") {
  HashVisitor seven;
  for (int i = 0; i < 7; ++i) seven("", HashVisitor().value());
  Samples samples;
  CHECK(samples.log_hash() == seven.text());
  wire::RobotOrder order{};
  order.header.seq = 1;
  samples.add(order);
  CHECK(samples.log_hash() == seven.text());  // no stream, as requests and faults
  wire::RobotMotion motion{};
  motion.header.seq = 1;
  samples.add(motion);
  const std::string with_one = samples.log_hash();
  CHECK(with_one != seven.text());
  motion.q_rad[6] = 1e-12;
  samples.add(motion);
  CHECK(samples.log_hash() != with_one);
}
