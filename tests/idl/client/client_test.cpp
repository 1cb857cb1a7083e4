#include "idl/client/client.hpp"

#include <string>

#include <catch2/catch.hpp>

#include "idl/convert.hpp"
#include "idl/endpoint.hpp"
#include "tests/idl/bus_fixture.hpp"

using namespace c3rt;
using namespace c3rt::client;
namespace test = c3rt::wire::test;

namespace {

constexpr double kLong = 60.0;  // of a busy machine [s]

/// Plant, impedance and planner in one process: they obey, refuse circles, and recover alone stays
/// without an answer. Ends when it is killed.
int play() {
  wire::Bus bus(test::settings(wire::ClockMode::kRealtime, 7));
  std::vector<std::unique_ptr<wire::Endpoint>> endpoints;
  for (const wire::Process process :
       {c3rt_v2_PROCESS_PLANT, c3rt_v2_PROCESS_IMPEDANCE, c3rt_v2_PROCESS_PLANNER}) {
    endpoints.push_back(
        std::make_unique<wire::Endpoint>(bus, process, wire::FaultScope{}, wire::Endpoint::Log{}));
    endpoints.back()->say(c3rt_v2_SERVICE_RUNNING, "here");
  }
  wire::Reader<wire::TaskTarget> targets(bus);
  wire::Reader<wire::PlannerWeights> weighed(bus);
  wire::Reader<wire::RobotOrder> orders(bus);
  wire::Writer<wire::RobotState> states(bus);
  while (true) {
    const std::int64_t now_ns = rt::now_ns();
    for (const auto& endpoint : endpoints) {
      endpoint->serve_requests(now_ns, [](c3rt_v2_RequestVerb verb) -> std::optional<wire::Answer> {
        if (verb != c3rt_v2_REQUEST_STOP) return std::nullopt;
        return wire::Answer{true, "stopped"};
      });
      endpoint->serve_faults(now_ns, [](const wire::FaultInject&) { return std::string(); });
    }
    wire::TaskTarget target{};
    while (targets.take(target)) {
      const task::Request request = wire::request(target);
      const bool ok = request.kind != "circle";
      endpoints.back()->replies().answer(
          target.request_id, ok,
          ok ? request.kind + " " + request.parameters.at(0).name + " " +
                   std::to_string(request.parameters.at(0).values.size())
             : "refused: no circles",
          now_ns);
    }
    endpoints.back()->replies().answer_refused(weighed, now_ns);
    wire::PlannerWeights asked{};
    while (weighed.take(asked)) {
      std::string text;
      for (const auto& [name, value] : wire::weights(asked))
        text += name + "=" + std::to_string(value) + ";";
      endpoints.back()->replies().answer(asked.request_id, true, text, now_ns);
    }
    endpoints.front()->replies().answer_refused(orders, now_ns);
    wire::RobotOrder order{};
    while (orders.take(order)) {
      endpoints.front()->replies().answer(
          order.request_id, order.kind != c3rt_v2_ORDER_THRESHOLDS,
          wire::name_of(order.kind) + std::string(order.engaged ? " engaged " : " ") +
              std::to_string(order.free_axes) + " " + std::to_string(order.force_W_n[1]),
          now_ns);
    }
    wire::RobotState state{};
    state.q_WE[0] = 1.0;
    state.p_WE_m[0] = 1e-3 * static_cast<double>(states.seq() % 1000);
    states.write(state, now_ns);
    usleep(2000);
  }
}

template <typename Error>
std::string thrown(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing";
}

}  // namespace

TEST_CASE("client: by domain alone it reads, asks, and hears what the processes answer") {
  unsetenv("CYCLONEDDS_URI");
  const test::Child processes(play);
  Client client(test::kDomain);

  const wire::RobotState first = client.newest<wire::RobotState>(kLong);
  CHECK(client.newest<wire::RobotState>(kLong).header.seq > first.header.seq);
  Reader<wire::RobotState> queue(client.bus(), 100);
  wire::RobotState before{}, state{};
  REQUIRE(queue.wait(before, kLong));
  for (int i = 0; i < 20; ++i) {
    REQUIRE(queue.wait(state, kLong));
    CHECK(state.header.seq > before.header.seq);
    before = state;
  }
  CHECK(queue.counters().refused_for(wire::Reason::kValue) == 0);

  const Reply reply = client.target("pose", {{"goals_m", {0.5, 0.1}}}, kLong);
  CHECK(reply.process == c3rt_v2_PROCESS_PLANNER);
  CHECK(reply.text == "pose goals_m 2");
  CHECK(thrown<Refused>([&] { client.target("circle", {}, kLong); }) ==
        "planner: refused: no circles");
  CHECK(client.weights({{"roll.R", 0.5}, {"roll.Q.ball_xy", 2e5}}, kLong).text ==
        "roll.Q.ball_xy=200000.000000;roll.R=0.500000;");
  CHECK(client.weights({}, kLong).text.empty());
  CHECK(thrown<Refused>([&] {
          client.weights({{"roll.R", -1.0}}, kLong);
        }) == "planner: refused: weights.value[0] is -1, expected 0 to 1000000000000");
  std::map<std::string, double> too_many;
  for (int i = 0; i < 33; ++i) too_many[std::to_string(i)] = 1.0;
  CHECK(thrown<std::invalid_argument>([&] { client.weights(too_many); }) ==
        "weights: expected at most 32, got 33");
  CHECK(client.stop(kLong).size() == 3);
  CHECK(thrown<NoAnswer>([&] { client.recover(0.2); }) ==
        "plant, impedance, planner did not answer for 0.2 s on domain " +
            std::to_string(test::kDomain) + ": c3rt status tells what runs");
  wire::FaultInject fault{};
  fault.process = c3rt_v2_PROCESS_PLANNER;
  fault.kind = c3rt_v2_FAULT_FREEZE_CAMERA;
  CHECK_THAT(thrown<Refused>([&] { client.fault(fault, kLong); }),
             Catch::StartsWith("planner: refused: "));
  CHECK(client.guide(5, false, kLong).text == "guiding engaged 5 0.000000");
  CHECK(client.release(kLong).text == "guiding 0 0.000000");
  CHECK(client.user_stop(true, kLong).text == "user stop engaged 0 0.000000");
  CHECK(client.push({0.0, 2.5, 0.0}, 0.1, kLong).process == c3rt_v2_PROCESS_PLANT);
  CHECK(thrown<Refused>([&] { client.thresholds({}, {}, kLong); }) ==
        "plant: refused: acceleration.collision_torque_nm[0] is 0, expected 0.1 to 1000");
  c3rt_v2_ContactThresholds steady{}, fast{};
  for (c3rt_v2_ContactThresholds* t : {&steady, &fast}) {
    for (double& torque : t->collision_torque_nm) torque = 20.0;
    for (double& force : t->collision_force_E_n) force = 20.0;
    for (double& torque : t->collision_torque_E_nm) torque = 20.0;
  }
  CHECK(thrown<Refused>([&] { client.thresholds(steady, fast, kLong); }) ==
        "plant: thresholds 0 0.000000");
  const Services services = client.status(0.5);
  REQUIRE(services[c3rt_v2_PROCESS_IMPEDANCE]);
  CHECK(std::string(services[c3rt_v2_PROCESS_IMPEDANCE]->text) == "here");
  CHECK_FALSE(services[c3rt_v2_PROCESS_VISION]);
}

TEST_CASE("client: where nobody is, it says which topic and which domain") {
  Client client(test::kDomain + 100);
  const std::string domain = "domain " + std::to_string(test::kDomain + 100);
  CHECK(thrown<NobodyListens>([&] { client.stop(); }) ==
        "nobody listens to service/request on " + domain);
  CHECK_THAT(thrown<NoAnswer>([&] { client.newest<wire::Plan>(0.05); }),
             Catch::StartsWith("plan: nothing has come for 0.05 s on " + domain));
}

TEST_CASE("client: a wrong domain or profile is named with what is expected") {
  CHECK(thrown<std::invalid_argument>([] { Client client(231); }) ==
        "domain: expected 0 to 230, got 231");
  CHECK(thrown<wire::ProfileError>([] { Client client(0, "loopbak"); }) ==
        "profile: expected loopback, lan, secure, secure_lan, or a file, got \"loopbak\"");
  CHECK(thrown<std::invalid_argument>([] {
          Client client(test::kDomain);
          client.target("pose", std::vector<Parameter>(17));
        }) == "parameters: expected at most 16, got 17");
}
