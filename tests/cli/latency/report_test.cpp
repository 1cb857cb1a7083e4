#include "cli/latency/report.hpp"

#include <filesystem>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/cli/folder.hpp"

using namespace c3rt::cli;
using namespace c3rt::cli::latency;
using Catch::Contains;

namespace {

constexpr std::int64_t kMs = 1'000'000;

Report report() {
  Report report;
  report.scenario = "circle_slow";
  report.profile = "loopback";
  report.duration = 60.0;
  report.load = 2;
  report.cores = 2;
  std::vector<double> samples;
  for (int i = 1; i <= 1000; ++i) samples.push_back(1e-6 * i);
  report.rows.push_back({"hop", kDdsStage, "there and back", distribution(samples), samples});
  Distribution told;
  told.count = 5;
  told.p50 = 2e-5;
  report.rows.push_back({"servo_compute", kProcessStage, "servo compute", told, {}});
  report.measured.success = {1000, 0.98, 0.9, 100 * kMs};
  report.measured.missed = {1000, 4, 3, {200 * kMs}};
  report.measured.stalls = {{50 * kMs, 62 * kMs}};
  for (int i = 0; i < 500; ++i) report.loop.push_back({i * kMs, 50'000});
  report.reference = report.loop;
  report.judgement = judge(report.measured);
  return report;
}

}  // namespace

TEST_CASE("latency.json has the quantiles of each time, and null for those that are not known") {
  const nlohmann::ordered_json json = to_json(report());
  CHECK(json["times_s"]["hop"]["p99"] == Approx(990e-6));
  CHECK(json["times_s"]["hop"]["count"] == 1000);
  CHECK(json["times_s"]["servo_compute"]["p50"] == 2e-5);
  CHECK(json["times_s"]["servo_compute"]["p99"].is_null());
  CHECK(json["success_rate"]["average"] == 0.98);
  CHECK(json["success_rate"]["minimum_at_s"] == Approx(0.1));
  CHECK(json["missed_cycles"]["outside_at_s"][0] == Approx(0.2));
  CHECK(json["missed_cycles"]["share_outside"] == Approx(1e-3));
  CHECK(json["stalls"][0]["at_s"] == Approx(0.05));
  CHECK(json["stalls"][0]["duration_s"] == Approx(0.012));
  CHECK(json["verdict"] == "good");
  CHECK(json["load"] == 2);
}

TEST_CASE("the text of latency names each time under its stage, and ends with the verdict") {
  const std::string said = text(report());
  CHECK_THAT(said, Contains("2 busy threads, profile loopback, circle_slow"));
  CHECK_THAT(said, Contains("there and back") && Contains("0.990"));
  CHECK_THAT(said, Contains("missed cycles: 4 of 1000, 3 of them within 1 stalls"));
  CHECK_THAT(said, Contains("not met  wakeup_p99_over_reference: -"));
  CHECK(said.rfind("good for 1 kHz") > said.rfind("success_rate_minimum"));
}

TEST_CASE("the picture of latency is drawn, of nothing as well") {
  const Folder folder;
  for (const Report& one : {report(), Report{}}) {
    const std::filesystem::path file = folder.path() / "latency.png";
    CHECK(draw(file, one) == "");
    CHECK(std::filesystem::remove(file));
  }
}
