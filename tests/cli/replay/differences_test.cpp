#include "cli/replay/differences.hpp"

#include <cmath>

#include <catch2/catch.hpp>

#include "idl/text.hpp"
#include "tests/idl/samples.hpp"

using namespace c3rt;
using namespace c3rt::cli::replay;

namespace {

wire::Plan plan() {
  auto sample = wire::test::plain<wire::Plan>();
  sample.header = {7, 3, 1'000'000};
  sample.knot_count = 2;
  sample.knots[1].p_WE_m[2] = 0.5;
  return sample;
}

}  // namespace

TEST_CASE("one bit is a difference: its field, both values and how far they are apart") {
  wire::Plan given = plan();
  given.knots[1].p_WE_m[2] = std::nextafter(0.5, 1.0);
  const auto found = differences(plan(), given);
  REQUIRE(found.size() == 1);
  CHECK(found[0].field == "knots[1].p_WE_m[2]");
  CHECK(found[0].recorded == "0.5");
  CHECK(found[0].given == "0.5000000000000001");
  CHECK(found[0].amount == std::ldexp(1.0, -53));  // the spacing of numbers from 0.5 to 1
  CHECK(without_places(found[0].field) == "knots.p_WE_m");
}

TEST_CASE("session, numbers and times that the machine measured are no differences") {
  wire::Plan given = plan();
  given.header.session_id = 8;
  given.header.seq = 99;
  given.solve_time_s = 0.25;
  CHECK(differences(plan(), given).empty());
  given.header.time_ns += 1;
  REQUIRE(differences(plan(), given).size() == 1);
  CHECK(differences(plan(), given)[0].field == "header.time_ns");
  wire::PlannerDebug debug{}, other{};
  other.plan_seq = 4;
  CHECK(differences(debug, other).empty());
}

TEST_CASE("words, and what one of two lists alone has, are told without an amount") {
  wire::Plan given = plan();
  wire::set_text(given.phase, "roll");
  given.status = c3rt_v2_PLAN_FALLBACK;
  given.knot_count = 1;
  const auto found = differences(plan(), given);
  const auto of = [&found](const std::string& field) {
    for (const Difference& each : found)
      if (each.field == field) return each;
    return Difference{};
  };
  CHECK(of("phase").recorded == "\"\"");
  CHECK(of("phase").given == "\"roll\"");
  CHECK(of("status").given == "fallback");
  CHECK(of("knots[1].p_WE_m[2]").recorded == "0.5");
  CHECK(of("knots[1].p_WE_m[2]").given.empty());
  CHECK(of("knot_count").amount == 1.0);
  CHECK(of("status").amount == 0.0);
}

TEST_CASE("every field of every topic is looked at") {
  wire::for_each_topic([](const auto& kind) {
    using T = std::decay_t<decltype(kind)>;
    const T none{}, all = wire::test::numbered<T>();
    CAPTURE(wire::topic<T>().name);
    CHECK_FALSE(differences(none, all).empty());
    CHECK(differences(all, all).empty());
  });
}
