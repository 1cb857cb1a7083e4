// The process c3rt-vision on a real bus, with this test as its plant.
#include "idl/process.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>
#include <unistd.h>

#include "controller/rt/periodic_clock.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/own_domain.hpp"

using namespace c3rt;

namespace {

const std::string kSource = C3RT_SOURCE_DIRECTORY;
const std::string kProfile = kSource + "/config/dds/loopback.xml";
constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kSecond = 1000 * kMs;
constexpr std::int64_t kPeriod = 12'500'000;  // 80 Hz [ns]
constexpr double kRadius = 0.0315, kTable = -0.0245;

std::string read_file(const std::string& path) {
  std::ifstream file(path);
  REQUIRE(file);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// The scenario circle_slow with the three cameras of this folder in place of its section `vision`,
/// and with what is replaced.
std::string camera_scenario(
    const std::vector<std::pair<std::string, std::string>>& replacements = {}) {
  std::string circle = read_file(kSource + "/config/scenarios/circle_slow.yaml");
  for (const auto& [from, to] : replacements) {
    std::size_t at = circle.find(from);
    REQUIRE(at != std::string::npos);
    for (; at != std::string::npos; at = circle.find(from, at + to.size()))
      circle.replace(at, from.size(), to);
  }
  const std::size_t vision = circle.find("\nvision:");
  REQUIRE(vision != std::string::npos);
  const std::string path = std::string(C3RT_BINARY_DIRECTORY) + "/three_cameras_scenario.yaml";
  std::ofstream file(path);
  file << circle.substr(0, vision) << "\nvision:\n";
  std::istringstream lines(read_file(kSource + "/tests/vision/three_cameras.yaml"));
  for (std::string line; std::getline(lines, line);) file << "  " << line << '\n';
  return path;
}

std::uint32_t test_domain() { return support::kOwnDomain; }

struct Child : test::ChildProcess {
  Child(const std::string& scenario, const std::string& clock, std::vector<std::string> more = {})
      : ChildProcess(test::process_command("c3rt-vision", scenario, test_domain(),
                                           (more.insert(more.end(), {"--clock", clock}), more))) {}
};

/// A ball that rolls along the circle at 0.08 m/s below an arm at rest.
wire::Scene scene_at(std::int64_t time_ns, bool exposure) {
  wire::Scene scene{};
  scene.exposure = exposure;
  const double q[] = {0.0, 0.275, 0.0, -2.222, 0.0, 2.497, 0.0};
  std::copy(std::begin(q), std::end(q), scene.q_rad);
  scene.object_count = 1;
  const double angle = -0.8 * 1e-9 * static_cast<double>(time_ns);
  const double p[] = {0.55 + 0.1 * std::cos(angle), 0.1 * std::sin(angle), kTable + kRadius};
  std::copy(std::begin(p), std::end(p), scene.objects[0].p_WB_m);
  scene.objects[0].q_WB[0] = 1.0;
  return scene;
}

double error(const wire::ObjectEstimate& estimate) {
  const wire::Scene truth = scene_at(estimate.exposure_ns, true);
  double sum = 0.0;
  for (int i = 0; i < 3; ++i) sum += std::pow(estimate.p_WB_m[i] - truth.objects[0].p_WB_m[i], 2);
  return std::sqrt(sum);
}

double p95(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values.at(values.size() * 95 / 100);
}

/// The plant's part of a lockstep run, as far as vision takes part in it.
class Plant {
 public:
  explicit Plant(const std::string& scenario, const std::vector<std::string>& more = {})
      : child_(scenario, "lockstep", more),
        bus_({test_domain(), kProfile, "client", wire::ClockMode::kLockstep, wire::draw_session()}),
        scenes_(bus_),
        faults_(bus_),
        estimates_(bus_),
        detections_(bus_),
        master_(bus_, {c3rt_v2_PROCESS_VISION}, 30 * kSecond) {}

  /// @return the estimate of this step, if one was due
  bool step(wire::ObjectEstimate& estimate,
            std::vector<wire::ObjectDetection>* detections = nullptr) {
    now_ns_ += kMs;
    const bool exposure = now_ns_ >= next_exposure_ns_;
    if (exposure) {
      next_exposure_ns_ += kPeriod;
      wire::Scene scene = scene_at(now_ns_, true);
      scenes_.write(scene, now_ns_);
    } else if (now_ns_ % (10 * kMs) == 0) {
      wire::Scene scene = scene_at(now_ns_, false);
      scenes_.write(scene, now_ns_);
    }
    const std::uint64_t refused_before = refused_estimates();
    REQUIRE(master_.advance(now_ns_));
    wire::ObjectDetection detection{};
    while (detections_.take(detection)) {
      if (detections != nullptr) detections->push_back(detection);
    }
    const bool found = estimates_.take(estimate);
    REQUIRE((found || refused_estimates() > refused_before) == exposure);
    return found;
  }
  /// Estimates that no reader lets in.
  std::uint64_t refused_estimates() const {
    return estimates_.counters().refused_for(wire::Reason::kValue);
  }
  /// Steps until an estimate satisfies the condition; false after two simulated seconds.
  bool until(const std::function<bool(const wire::ObjectEstimate&)>& condition) {
    wire::ObjectEstimate estimate{};
    for (int i = 0; i < 2000; ++i) {
      if (step(estimate) && condition(estimate)) return true;
    }
    return false;
  }
  void inject(c3rt_v2_FaultKind kind, int index, double duration_s) {
    wire::FaultInject fault{};
    fault.process = c3rt_v2_PROCESS_VISION;
    fault.kind = kind;
    fault.index = index;
    fault.duration_s = duration_s;
    faults_.write(fault, now_ns_);
  }
  std::int64_t now_ns() const { return now_ns_; }
  Child& child() { return child_; }

 private:
  Child child_;
  wire::Bus bus_;
  wire::Writer<wire::Scene> scenes_;
  wire::Writer<wire::FaultInject> faults_;
  wire::Reader<wire::ObjectEstimate> estimates_;
  wire::Reader<wire::ObjectDetection> detections_;
  wire::LockstepMaster master_;
  std::int64_t now_ns_ = 0, next_exposure_ns_ = 0;
};

struct Trace {
  std::vector<wire::ObjectEstimate> estimates;
  std::vector<wire::ObjectDetection> detections;
};

Trace trace(const std::string& scenario, int steps, const std::vector<std::string>& more = {}) {
  Plant plant(scenario, more);
  Trace result;
  wire::ObjectEstimate estimate{};
  for (int i = 0; i < steps; ++i) {
    if (plant.step(estimate, &result.detections)) result.estimates.push_back(estimate);
  }
  return result;
}

bool same_bits(const Trace& a, const Trace& b) {
  if (a.estimates.size() != b.estimates.size()) return false;
  for (std::size_t i = 0; i < a.estimates.size(); ++i) {
    const wire::ObjectEstimate &x = a.estimates[i], &y = b.estimates[i];
    for (int k = 0; k < 3; ++k) {
      if (x.p_WB_m[k] != y.p_WB_m[k] || x.p_measured_m[k] != y.p_measured_m[k] ||
          x.v_WB_m_per_s[k] != y.v_WB_m_per_s[k]) {
        return false;
      }
    }
    if (x.header.time_ns != y.header.time_ns || x.sensors_used != y.sensors_used) return false;
  }
  return true;
}

TEST_CASE(
    "in lockstep three cameras give one estimate per exposure, within 1 mm, stamped with the "
    "scenario's latency") {
  const std::string scenario = camera_scenario();
  const Trace first = trace(scenario, 1500);
  // at 0, 12.5, 25, … 1500 ms, each at the next full millisecond but the first, which is at 1 ms
  REQUIRE(first.estimates.size() == 121);
  REQUIRE(first.detections.size() == 3 * first.estimates.size());
  std::vector<double> errors;
  for (const wire::ObjectEstimate& estimate : first.estimates) {
    REQUIRE(estimate.header.time_ns == estimate.exposure_ns + 8 * kMs);
    REQUIRE(estimate.valid);
    errors.push_back(error(estimate));
  }
  CHECK(p95(errors) < 1e-3);
  // clockwise at 0.08 m/s, so at the start along -y
  CHECK(first.estimates[10].v_WB_m_per_s[1] == Approx(-0.08).margin(0.02));
  CHECK(std::count_if(
            first.detections.begin(), first.detections.end(), [](const wire::ObjectDetection& d) {
              return d.found && d.used && d.radius_px > 5;
            }) > static_cast<std::ptrdiff_t>(0.9 * static_cast<double>(first.detections.size())));
  CHECK(same_bits(first, trace(scenario, 1500)));
}

TEST_CASE(
    "in lockstep three balls in contact have an estimate each, within 1 mm, by their number") {
  std::string balls;
  for (const char* y : {"0", "0.063", "0.126"}) {
    balls += std::string("    - {shape: sphere, position_m: [0.65, ") + y +
             "], radius_m: 0.0315, mass_kg: 0.132}\n";
  }
  Child child(
      camera_scenario(
          {{"    - {shape: sphere, position_m: [0.55, 0.1], radius_m: 0.0315, mass_kg: 0.132, "
            "start_spread_m: 0.01}\n",
            balls},
           {"friction_table: 1.0", "friction_balls: 1.0"},
           {" ball_z: 0,", ""},
           {" ball_z: 1,", ""},
           {"table_normal", "balls_normal"},
           {"table_tangential", "balls_tangential"},
           {"ball_table: true", "ball_ball: true"},
           {"    return_back_m:",
            "    look_ahead_s: 0\n    beside_weight: 0\n    change_margin_m: 0\n"
            "    room_ahead_m: 0\n    return_back_m:"}}),
      "lockstep");
  wire::Bus bus(
      {test_domain(), kProfile, "client", wire::ClockMode::kLockstep, wire::draw_session()});
  wire::Writer<wire::Scene> scenes(bus);
  wire::Reader<wire::ObjectEstimate> estimates(bus, 64);
  wire::Reader<wire::ObjectDetection> detections(bus, 64);
  wire::LockstepMaster master(bus, {c3rt_v2_PROCESS_VISION}, 30 * kSecond);
  std::array<std::vector<double>, 3> errors;
  std::array<int, 3> used{};
  for (std::int64_t now_ns = kMs, next_ns = 0; now_ns < kSecond; now_ns += kMs) {
    if (now_ns >= next_ns) {
      next_ns += kPeriod;
      wire::Scene scene = scene_at(now_ns, true);
      scene.object_count = 3;
      for (int ball = 1; ball < 3; ++ball) {
        std::copy_n(scene.objects[0].p_WB_m, 3, scene.objects[ball].p_WB_m);
        scene.objects[ball].p_WB_m[1] += 2 * kRadius * ball;
        scene.objects[ball].q_WB[0] = 1.0;
      }
      scenes.write(scene, now_ns);
    }
    REQUIRE(master.advance(now_ns));
    wire::ObjectEstimate estimate{};
    while (estimates.take(estimate)) {
      REQUIRE(estimate.object_index >= 0);
      REQUIRE(estimate.object_index < 3);
      REQUIRE(estimate.valid);
      estimate.p_WB_m[1] -= 2 * kRadius * estimate.object_index;
      errors.at(static_cast<std::size_t>(estimate.object_index)).push_back(error(estimate));
    }
    wire::ObjectDetection detection{};
    while (detections.take(detection)) {
      if (detection.used) ++used.at(static_cast<std::size_t>(detection.object_index));
    }
  }
  for (std::size_t ball = 0; ball < 3; ++ball) {
    CAPTURE(ball);
    REQUIRE(errors[ball].size() == 80);
    CHECK(p95(errors[ball]) < 1e-3);
    CHECK(used[ball] > 160);
  }
}

TEST_CASE("in lockstep the emulated sensor's noise is the seed's, bit for bit") {
  const std::string scenario = kSource + "/config/scenarios/circle_slow.yaml";
  const auto with_seed = [&](const std::string& seed) {
    return trace(scenario, 300, {"--seed", seed, "--set", "vision.emulated.noise_m=0.001"});
  };
  const Trace one = with_seed("1");
  REQUIRE(one.estimates.size() == 25);
  CHECK(same_bits(one, with_seed("1")));
  CHECK_FALSE(same_bits(one, with_seed("2")));
  for (const wire::ObjectEstimate& estimate : one.estimates) CHECK(error(estimate) < 0.008);
}

TEST_CASE("a frozen camera is done without, a hidden ball is reported lost and found again") {
  Plant plant(camera_scenario());
  REQUIRE(plant.until([](const auto& e) { return e.valid && e.sensors_used == 3; }));
  plant.inject(c3rt_v2_FAULT_FREEZE_CAMERA, 0, 3600);
  REQUIRE(plant.until([](const auto& e) { return e.sensors_used == 2; }));
  wire::ObjectEstimate last_seen{};
  REQUIRE(plant.until([&](const auto& e) {
    last_seen = e;
    return e.valid && error(e) < 2e-3;
  }));

  plant.inject(c3rt_v2_FAULT_LOSE_OBJECT, 0, 3600);
  REQUIRE(plant.until([&](const auto& e) {
    if (e.sensors_used > 0) last_seen = e;
    return !e.valid;
  }));
  REQUIRE(plant.until([&](const auto& e) { return e.p_WB_m[0] == last_seen.p_WB_m[0]; }));
  plant.inject(c3rt_v2_FAULT_NONE, 0, 0);
  REQUIRE(
      plant.until([](const auto& e) { return e.valid && e.sensors_used == 3 && error(e) < 2e-3; }));

  plant.inject(c3rt_v2_FAULT_NAN, 0, 3600);
  CHECK_FALSE(plant.until([](const auto&) { return true; }));
  CHECK(plant.refused_estimates() > 100);
}

TEST_CASE("in realtime an estimate follows each exposure, and SIGTERM ends the process cleanly") {
  Child child(camera_scenario(), "realtime");
  wire::Bus bus(
      {test_domain(), kProfile, "client", wire::ClockMode::kRealtime, wire::draw_session()});
  wire::Writer<wire::Scene> scenes(bus);
  wire::Reader<wire::ObjectEstimate> estimates(bus);
  rt::PeriodicClock clock(kPeriod);
  const std::int64_t start_ns = rt::now_ns();
  int exposures = 0, followed = 0;
  while (exposures < 160 && rt::now_ns() - start_ns < 20 * kSecond) {
    const std::int64_t now_ns = clock.wait().woke_ns;
    wire::Scene scene = scene_at(now_ns, true);
    scenes.write(scene, now_ns);
    wire::ObjectEstimate estimate{};
    while (estimates.take(estimate)) {
      ++followed;
      CHECK(estimate.header.time_ns > estimate.exposure_ns);
    }
    if (followed > 0) ++exposures;
  }
  REQUIRE(exposures == 160);
  // two seconds; a machine that is busy elsewhere may skip some
  CHECK(followed > exposures / 2);
  child.signal(SIGTERM);
  CHECK(child.wait() == 0);
}

TEST_CASE("a scenario that asks for the impossible is refused before anything starts") {
  const std::string scenario = kSource + "/config/scenarios/circle_slow.yaml";
  Child without_cameras(scenario, "lockstep",
                        {"--set", "vision.source=cameras", "--set", "vision.cameras=[]"});
  CHECK(without_cameras.wait() == 2);
  Child unknown(scenario, "lockstep", {"--set", "vision.rate=80"});
  CHECK(unknown.wait() == 2);
}

}  // namespace
