#include "idl/endpoint.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include <catch2/catch.hpp>
#include <unistd.h>

#include "tests/idl/bus_fixture.hpp"

using namespace c3rt;
using namespace c3rt::wire;
namespace test = c3rt::wire::test;

namespace {

using test::eventually;
using test::kMs;
using test::kSecond;

const double kNan = std::numeric_limits<double>::quiet_NaN();
const double kInfinity = std::numeric_limits<double>::infinity();

/// A process's endpoint and a client of it on one bus.
struct World {
  explicit World(Process process, const FaultScope& scope = {})
      : bus(test::settings(ClockMode::kRealtime, 1)),
        endpoint(bus, process, scope,
                 [this](bool attention, const std::string& said) {
                   if (said.compare(0, 5, "fault") == 0) log.emplace_back(attention, said);
                 }),
        requests(bus),
        faults(bus),
        replies(bus),
        statuses(bus) {
    REQUIRE(eventually([&] {
      return requests.matched_readers() > 0 && faults.matched_readers() > 0 &&
             replies.matched_writers() > 0;
    }));
  }
  void ask(std::uint64_t id, Process process, c3rt_v2_RequestVerb verb) {
    ServiceRequest request{};
    request.request_id = id;
    request.process = process;
    request.verb = verb;
    REQUIRE(requests.write(request, rt::now_ns()));
  }
  void inject(std::uint64_t id, Process process, c3rt_v2_FaultKind kind, double duration) {
    FaultInject fault{};
    fault.request_id = id;
    fault.process = process;
    fault.kind = kind;
    fault.duration_s = duration;
    REQUIRE(faults.write(fault, rt::now_ns()));
  }
  /// Serves until the reply to the request is there.
  template <typename Serve>
  ServiceReply reply_to(std::uint64_t id, Serve&& serve) {
    ServiceReply reply{};
    REQUIRE(eventually([&] {
      serve();
      while (replies.take(reply)) {
        if (reply.request_id == id) return true;
      }
      return false;
    }));
    return reply;
  }

  std::vector<std::pair<bool, std::string>> log;  // of faults
  Bus bus;
  Endpoint endpoint;
  Writer<ServiceRequest> requests;
  Writer<FaultInject> faults;
  Reader<ServiceReply> replies;
  Reader<ServiceStatus> statuses;
};

TEST_CASE("endpoint: a process obeys its own requests in order, and never sees a shutdown") {
  World world(c3rt_v2_PROCESS_VISION);
  std::vector<c3rt_v2_RequestVerb> obeyed;
  world.ask(1, c3rt_v2_PROCESS_VISION, c3rt_v2_REQUEST_SHUTDOWN);
  world.ask(2, c3rt_v2_PROCESS_PLANNER, c3rt_v2_REQUEST_STOP);
  world.ask(3, c3rt_v2_PROCESS_VISION, c3rt_v2_REQUEST_STOP);
  world.ask(4, c3rt_v2_PROCESS_VISION, c3rt_v2_REQUEST_RECOVER);
  const ServiceReply reply = world.reply_to(4, [&] {
    world.endpoint.serve_requests(rt::now_ns(),
                                  [&](c3rt_v2_RequestVerb verb) -> std::optional<Answer> {
                                    obeyed.push_back(verb);
                                    return Answer{verb == c3rt_v2_REQUEST_RECOVER, "heard"};
                                  });
  });
  CHECK(obeyed == std::vector<c3rt_v2_RequestVerb>{c3rt_v2_REQUEST_STOP, c3rt_v2_REQUEST_RECOVER});
  CHECK(reply.ok);
  CHECK(reply.process == c3rt_v2_PROCESS_VISION);
  CHECK(std::string(reply.text) == "heard");
}

TEST_CASE("endpoint: so many requests wait for an answer, and one more is refused") {
  World world(c3rt_v2_PROCESS_PLANT);
  std::size_t obeyed = 0;
  const auto serve = [&] {
    world.endpoint.serve_requests(rt::now_ns(), [&](c3rt_v2_RequestVerb) {
      ++obeyed;
      return std::optional<Answer>();
    });
  };
  for (std::size_t id = 1; id <= kMostPending; ++id) {
    world.ask(id, c3rt_v2_PROCESS_PLANT, c3rt_v2_REQUEST_STOP);
    REQUIRE(eventually([&] {
      serve();
      return obeyed == id;
    }));
  }
  world.ask(kMostPending + 1, c3rt_v2_PROCESS_PLANT, c3rt_v2_REQUEST_STOP);
  const ServiceReply reply = world.reply_to(kMostPending + 1, serve);
  CHECK_FALSE(reply.ok);
  CHECK(std::string(reply.text) == "too many requests wait for an answer");
  CHECK(obeyed == kMostPending);
}

TEST_CASE("endpoint: what is not answered at once is judged after two cycles, at last when late") {
  World world(c3rt_v2_PROCESS_PLANT);
  world.ask(1, c3rt_v2_PROCESS_PLANT, c3rt_v2_REQUEST_STOP);
  int obeyed = 0, judged = 0;
  constexpr std::uint64_t kTaken = 100;
  REQUIRE(eventually([&] {
    world.endpoint.serve_requests(
        rt::now_ns(),
        [&](c3rt_v2_RequestVerb) {
          ++obeyed;
          return std::optional<Answer>();
        },
        kTaken);
    return obeyed == 1;
  }));
  bool was_late = false;
  const auto judge = [&](c3rt_v2_RequestVerb verb, bool late) {
    CHECK(verb == c3rt_v2_REQUEST_STOP);
    ++judged;
    was_late = late;
    return late ? std::optional<Answer>({false, "does not stand yet"}) : std::nullopt;
  };
  for (std::uint64_t cycle = kTaken; cycle < kTaken + kAnswerWithinCycles; ++cycle)
    world.endpoint.answer_pending(rt::now_ns(), cycle, judge);
  CHECK(judged == static_cast<int>(kAnswerWithinCycles - kCyclesToObey));
  CHECK_FALSE(was_late);
  world.endpoint.answer_pending(rt::now_ns(), kTaken + kAnswerWithinCycles, judge);
  CHECK(was_late);
  const ServiceReply reply = world.reply_to(1, [] {});
  CHECK_FALSE(reply.ok);
  CHECK(std::string(reply.text) == "does not stand yet");
  // answered once
  const int before = judged;
  world.endpoint.answer_pending(rt::now_ns(), kTaken + 2 * kAnswerWithinCycles, judge);
  CHECK(judged == before);
}

TEST_CASE("endpoint: of every process, a fault that no world could do is answered, not done") {
  for (const Process process : {c3rt_v2_PROCESS_PLANT, c3rt_v2_PROCESS_IMPEDANCE,
                                c3rt_v2_PROCESS_PLANNER, c3rt_v2_PROCESS_VISION}) {
    World world(process);
    int injected = 0;
    const auto serve = [&] {
      world.endpoint.serve_faults(rt::now_ns(), [&](const FaultInject&) {
        ++injected;
        return std::string();
      });
    };
    std::uint64_t id = 0;
    for (const auto kind : {c3rt_v2_FAULT_STALL, c3rt_v2_FAULT_NAN}) {
      for (const double bad : {kNan, kInfinity, -kInfinity, -1.0, 0.0, 1e9}) {
        CAPTURE(process_name(process), kind, bad);
        world.inject(++id, process, kind, bad);
        const ServiceReply reply = world.reply_to(id, serve);
        CHECK_FALSE(reply.ok);
        CHECK_THAT(reply.text, Catch::Contains("refused: "));
      }
    }
    CHECK(injected == 0);
    world.inject(++id, process, c3rt_v2_FAULT_STALL, 1.0);
    const ServiceReply reply = world.reply_to(id, serve);
    CHECK(reply.ok);
    CHECK(injected == 1);
    REQUIRE_FALSE(world.log.empty());
    CHECK(world.log.back() == std::pair<bool, std::string>(false, "fault stall for 1 s"));
  }
}

TEST_CASE("endpoint: a fault of another process is left alone; one that cannot act says why") {
  World world(c3rt_v2_PROCESS_VISION, {{}, 3});
  std::vector<c3rt_v2_FaultKind> injected;
  const auto serve = [&] {
    world.endpoint.serve_faults(rt::now_ns(), [&](const FaultInject& fault) {
      injected.push_back(fault.kind);
      return std::string("too many faults at once");
    });
  };
  world.inject(1, c3rt_v2_PROCESS_PLANNER, c3rt_v2_FAULT_STALL, 1.0);
  world.inject(2, c3rt_v2_PROCESS_VISION, c3rt_v2_FAULT_LOSE_OBJECT, 1.0);
  const ServiceReply reply = world.reply_to(2, serve);
  CHECK_FALSE(reply.ok);
  CHECK(std::string(reply.text) == "refused: too many faults at once");
  CHECK(injected == std::vector<c3rt_v2_FaultKind>{c3rt_v2_FAULT_LOSE_OBJECT});
  REQUIRE(world.log.size() == 1);
  CHECK(world.log.back().first);
}

TEST_CASE("endpoint: a stall and a NaN last as long as was asked, or until every fault ends") {
  FaultWindows windows;
  CHECK_FALSE(windows.stalls(kSecond));
  FaultInject fault{};
  fault.kind = c3rt_v2_FAULT_STALL;
  fault.duration_s = 0.5;
  windows.begin(fault, kSecond);
  fault.kind = c3rt_v2_FAULT_NAN;
  fault.duration_s = 2.0;
  windows.begin(fault, kSecond);
  CHECK(windows.stalls(kSecond + 500 * kMs - 1));
  CHECK_FALSE(windows.stalls(kSecond + 500 * kMs));
  CHECK(windows.spoils(3 * kSecond - 1));
  CHECK_FALSE(windows.spoils(3 * kSecond));
  // other kinds are not its business
  fault.kind = c3rt_v2_FAULT_LOSE_OBJECT;
  fault.duration_s = 100.0;
  windows.begin(fault, kSecond);
  CHECK_FALSE(windows.spoils(3 * kSecond));
  fault.kind = c3rt_v2_FAULT_NONE;
  fault.duration_s = kNan;
  windows.begin(fault, kSecond);
  CHECK_FALSE(windows.stalls(kSecond));
  CHECK_FALSE(windows.spoils(kSecond));
}

TEST_CASE(
    "endpoint: what a process says of itself is new only when it differs, and is its status") {
  World world(c3rt_v2_PROCESS_PLANNER);
  CHECK(world.endpoint.say(c3rt_v2_SERVICE_RUNNING, "rolls"));
  CHECK_FALSE(world.endpoint.say(c3rt_v2_SERVICE_RUNNING, "rolls"));
  CHECK(world.endpoint.say(c3rt_v2_SERVICE_DEGRADED, "rolls"));
  ServiceStatus status{};
  CHECK(eventually([&] {
    world.statuses.take_newest(status);
    return status.state == c3rt_v2_SERVICE_DEGRADED && std::string(status.text) == "rolls";
  }));
  CHECK(status.process == c3rt_v2_PROCESS_PLANNER);
}

}  // namespace
