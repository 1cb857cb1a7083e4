#include "cli/chaos/stranger.hpp"

#include <memory>

#include <catch2/catch.hpp>

#include "cli/chaos/kinds.hpp"
#include "controller/base/time.hpp"
#include "idl/exchange.hpp"

using namespace c3rt;
using namespace c3rt::cli::chaos;

namespace {

wire::BusSettings settings(const std::shared_ptr<wire::Exchange>& exchange) {
  wire::BusSettings result;
  result.clock = wire::ClockMode::kLockstep;
  result.session_id = 7;
  result.exchange = exchange;
  return result;
}

Fault fault(std::string_view kind, std::string_view target, double rate) {
  Fault result;
  for (const Kind& known : kinds()) {
    if (known.name == kind) result.kind = &known;
  }
  REQUIRE(result.kind != nullptr);
  result.target = target;
  result.amount = rate;
  return result;
}

}  // namespace

TEST_CASE("stranger: a second writer misleads with what it heard, and the first one is obeyed") {
  const auto exchange = wire::make_exchange();
  wire::Bus plant(settings(exchange)), impedance(settings(exchange)), own(settings(exchange));
  wire::Writer<wire::RobotState> states(plant);
  wire::Reader<wire::RobotState> reader(impedance);
  Stranger stranger(own, fault("second-writer", "robot/state", 1000.0));
  wire::RobotState state{}, taken{};
  state.q_rad[0] = 0.01;
  stranger.speak(base::nanoseconds(1.0));
  CHECK_FALSE(reader.take(taken));  // it has nothing to mislead with
  REQUIRE(states.write(state, 1));
  REQUIRE(reader.take(taken));
  for (int i = 0; i <= 50; ++i) stranger.speak(base::nanoseconds(1.0 + 0.001 * i));
  CHECK_FALSE(reader.take(taken));
  CHECK(reader.counters().refused_for(wire::Reason::kSecondWriter) == Approx(50.0).margin(1.0));
  REQUIRE(states.write(state, 2));
  REQUIRE(reader.take(taken));
  CHECK(taken.q_rad[0] == 0.01);
}

TEST_CASE("stranger: a flood comes at its rate and is refused") {
  for (const std::string_view topic : flooded_topics()) {
    CAPTURE(topic);
    wire::with_topic(topic, [&](const auto& sample) {
      using T = std::decay_t<decltype(sample)>;
      if constexpr (wire::kAnswered<T>) {
        const auto exchange = wire::make_exchange();
        wire::Bus plant(settings(exchange)), own(settings(exchange));
        wire::Reader<T> reader(plant);
        Stranger stranger(own, fault("flood", topic, 2000.0));
        T taken{};
        int granted = 0;
        for (int i = 0; i <= 500; ++i) {
          stranger.speak(base::nanoseconds(1.0 + 0.005 * i));
          while (reader.take(taken)) ++granted;
        }
        CHECK(granted == 0);
        const auto counters = reader.counters();
        std::uint64_t refused = 0;
        for (const std::uint64_t count : counters.refused) refused += count;
        CHECK(refused == Approx(5000.0).margin(2.0));
      }
    });
  }
}
