#include "cli/recording/in_order.hpp"

#include <string>
#include <vector>

#include <catch2/catch.hpp>

using namespace c3rt;
using namespace c3rt::cli;

namespace {

constexpr std::int64_t kMs = 1'000'000;

/// Keeps what it hears, as "robot/state 3 @ 12".
class Ears final : public TimedListener {
 public:
  void at(std::int64_t time_ns) override { time_ns_ = time_ns; }
#define C3RT_TOPIC(Type, ...) \
  void hear(const wire::Type& sample) override { keep(sample); }
  C3RT_TOPICS(C3RT_TOPIC)
#undef C3RT_TOPIC
  bool has_enough() const override { return heard.size() == most; }

  std::vector<std::string> heard;
  std::size_t most = 1000;

 private:
  template <typename T>
  void keep(const T& sample) {
    heard.push_back(std::string(wire::topic<T>().name) + " " + std::to_string(sample.header.seq) +
                    " @ " + std::to_string(time_ns_ / kMs));
  }
  std::int64_t time_ns_ = 0;
};

template <typename T>
T at(std::uint64_t seq, std::int64_t time_ms) {
  T sample{};
  sample.header = {7, seq, time_ms * kMs};
  return sample;
}

using Words = std::vector<std::string>;

}  // namespace

TEST_CASE("what was taken topic by topic is heard by time, of equal times in the table's order") {
  Ears ears;
  InOrder in_order(ears, 10 * kMs);
  for (int i = 0; i < 2; ++i) in_order.hear(at<wire::RobotCommand>(1 + i, 10 + i));
  for (int i = 0; i < 3; ++i) in_order.hear(at<wire::RobotState>(1 + i, 10 + i));
  in_order.finish();
  CHECK(ears.heard == Words{"robot/state 1 @ 10", "robot/command 1 @ 10", "robot/state 2 @ 11",
                            "robot/command 2 @ 11", "robot/state 3 @ 12"});
}

TEST_CASE("a topic's shift moves it, and a topic never goes back behind itself") {
  Ears ears;
  InOrder::Shifts shifts{};
  shifts[wire::table::kPlaceOfPlan] = -5 * kMs;
  InOrder in_order(ears, 0, shifts);
  in_order.hear(at<wire::RobotState>(1, 12));
  in_order.hear(at<wire::Plan>(1, 20));
  in_order.hear(at<wire::Plan>(2, 16));
  in_order.finish();
  CHECK(ears.heard == Words{"robot/state 1 @ 12", "plan 1 @ 15", "plan 2 @ 15"});
}

TEST_CASE("of clients and of the words of processes the place in the file counts, not their time") {
  Ears ears;
  InOrder in_order(ears, 100 * kMs);
  // an hour old: kept for whoever comes late
  in_order.hear(at<wire::ServiceStatus>(1, -3'600'000));
  in_order.hear(at<wire::RobotState>(1, 100));
  in_order.hear(at<wire::RobotState>(2, 101));
  in_order.hear(at<wire::TaskTarget>(1, 9'000'000));  // of another clock
  in_order.hear(at<wire::RobotState>(3, 102));
  in_order.finish();
  CHECK(ears.heard == Words{"robot/state 1 @ 100", "service/status 1 @ 100", "robot/state 2 @ 101",
                            "task/target 1 @ 101", "robot/state 3 @ 102"});
}

TEST_CASE("a long recording is heard while it is read, and no more once its listener has enough") {
  Ears ears;
  ears.most = 3;
  InOrder in_order(ears, 0);
  for (int i = 1; i <= 4000; ++i) {
    in_order.hear(at<wire::RobotState>(i, i));
    // so much may still come out of order
    if (i == 2002) CHECK(ears.heard == Words{"robot/state 1 @ 1"});
  }
  in_order.finish();
  CHECK(ears.heard.size() == 3);
  CHECK(in_order.has_enough());
}
