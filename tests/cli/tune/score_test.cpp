// Which of two candidates is better.
#include "cli/tune/score.hpp"

#include <cmath>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "cli/exit_status.hpp"

using namespace c3rt::cli::tune;
using c3rt::cli::kDone;
using c3rt::cli::kProcessFailed;
using c3rt::cli::campaign::RunResult;
using nlohmann::ordered_json;

namespace {

RunResult result(double value, double limit, double time) {
  RunResult result;
  result.status = kDone;
  result.report = {
      {"criteria",
       {{{"name", "time"}, {"value", value}, {"limit", limit}, {"met", value <= limit}}}},
      {"time_s", time}};
  return result;
}

RunResult failed() {
  RunResult result;
  result.status = kProcessFailed;
  return result;
}

}  // namespace

TEST_CASE("runs that failed count before criteria, criteria before the figure") {
  const Score met = score({result(9, 10, 9)}, "time_s", false),
              slower = score({result(9.5, 10, 9.5)}, "time_s", false),
              missed = score({result(20, 10, 1)}, "time_s", false),
              broken = score({result(9, 10, 9), failed()}, "time_s", false);
  CHECK(met < slower);
  CHECK(slower < missed);
  CHECK(missed < broken);
  CHECK_FALSE(met < met);
}

TEST_CASE("a criterion is missed by its share, a value that is not there wholly") {
  CHECK(score({result(20, 10, 1)}, "time_s", false).shortfall == Approx(0.5));
  CHECK(score({result(10.001, 10, 1)}, "time_s", false).shortfall == Approx(0.01));
  RunResult none = result(1, 0, 1);
  none.report["criteria"][0]["value"] = nullptr;
  CHECK(score({none, result(9, 10, 1)}, "time_s", false).shortfall == 1.0);
}

TEST_CASE("a figure is the mean over the runs; one that does not give it makes it infinite") {
  CHECK(score({result(1, 2, 4), result(1, 2, 8)}, "time_s", false).figure == Approx(6.0));
  CHECK(score({result(1, 2, 4), result(1, 2, 8)}, "time_s", true).figure == Approx(-6.0));
  RunResult none = result(1, 2, 4);
  none.report.erase("time_s");
  CHECK(std::isinf(score({none, result(1, 2, 8)}, "time_s", true).figure));
  CHECK(text(score({none}, "time_s", true), "time_s", true) ==
        "all criteria met, time_s not reached");
}

TEST_CASE("ranks are places, and equals share one") {
  const Score a{0, 0.0, 1.0}, b{0, 0.0, 2.0}, c{1, 0.0, 0.0};
  CHECK(ranks({c, b, a, b}) == std::vector<double>{3.0, 1.0, 0.0, 1.0});
}
