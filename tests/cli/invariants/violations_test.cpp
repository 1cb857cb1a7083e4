#include "cli/invariants/violations.hpp"

#include <catch2/catch.hpp>

using namespace c3rt::cli::invariants;

TEST_CASE(
    "violations: one that goes on is one, with its worst value; after a second it is another") {
  Violations violations;
  violations.begin_pass(3, 17);
  for (int i = 0; i < 500; ++i)
    violations.add("torque", "robot/state", 1.0 + 0.001 * i, i == 200 ? 99.0 : 88.0, 87.0, "N m");
  CHECK(violations.count() == 1);
  violations.add("torque", "robot/state", 3.0, 88.0, 87.0, "N m");
  CHECK(violations.count() == 2);
  // another subject is another one at once
  violations.add("torque", "robot/command", 3.0, 88.0, 87.0, "N m");
  CHECK(violations.counts().at("torque") == 3);
  const Violation& first = violations.kept().front();
  CHECK(first.time == Approx(1.0));
  CHECK(first.value == 99.0);
  CHECK(first.limit == 87.0);
  CHECK(first.pass == 3);
  CHECK(first.seed == 17);
  CHECK(describe(first) == "torque of robot/state at 1.000 s: 99 N m, limit 87 (pass 3, seed 17)");
}

TEST_CASE("violations: a pass begins without those of the one before") {
  Violations violations;
  for (std::uint64_t pass = 1; pass <= 3; ++pass) {
    violations.begin_pass(pass, pass);
    violations.add("reflex", "robot/state", 0.5, 1.0, 0.0, "");
  }
  CHECK(violations.count() == 3);
}

TEST_CASE("violations: what is looked at seldom goes on from one look to the next") {
  Violations violations;
  for (int i = 0; i < 10; ++i)
    violations.add("memory", "plant", 300.0 + 5.0 * i, 2e8, 1e8, "bytes", 15.0);
  CHECK(violations.count() == 1);
  violations.add("memory", "plant", 400.0, 2e8, 1e8, "bytes", 15.0);
  CHECK(violations.count() == 2);
}

TEST_CASE("violations: a person who looks on is told the first of each, once") {
  Violations violations;
  CHECK(violations.take_news().empty());
  violations.begin_pass(2, 5);
  violations.add("memory", "plant", 300.0, 2e8, 1e8, "bytes");
  violations.add("memory", "plant", 400.0, 3e8, 1e8, "bytes");
  violations.add("memory", "vision", 301.0, 2e8, 1e8, "bytes");
  const std::vector<Violation> news = violations.take_news();
  REQUIRE(news.size() == 2);
  CHECK(news[0].subject == "plant");
  CHECK(news[0].time == 300.0);
  CHECK(news[0].seed == 5);
  CHECK(news[1].subject == "vision");
  violations.begin_pass(3, 6);
  violations.add("memory", "plant", 300.0, 2e8, 1e8, "bytes");
  CHECK(violations.take_news().empty());
}

TEST_CASE("violations: the first ones are kept, all are counted") {
  Violations violations;
  for (int i = 0; i < 10'000; ++i) violations.add("object", "sim/scene", 2.0 * i, 0.03, 0.02, "m");
  CHECK(violations.count() == 10'000);
  CHECK(violations.kept().size() == Violations::kMostKept);
  CHECK(violations.kept().back().time == Approx(2.0 * (Violations::kMostKept - 1)));
}
