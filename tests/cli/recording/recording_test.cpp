#include "cli/recording/recording.hpp"

#include <fstream>
#include <map>
#include <string>

#include <catch2/catch.hpp>

#include "cli/recording/export.hpp"
#include "cli/recording/samples.hpp"
#include "tests/cli/folder.hpp"
#include "tests/idl/samples.hpp"

using namespace c3rt;
using namespace c3rt::cli;

namespace {

using wire::test::plain;

/// Counts what it hears, and keeps it as a run does.
class Ears final : public Listener {
 public:
#define C3RT_TOPIC(Type, ...)                    \
  void hear(const wire::Type& sample) override { \
    ++heard[wire::topic<wire::Type>().name];     \
    samples.add(sample);                         \
  }
  C3RT_TOPICS(C3RT_TOPIC)
#undef C3RT_TOPIC
  std::map<std::string, int> heard;
  Samples samples;
};

TEST_CASE("recording: every topic but those that keep time is recorded, and played again") {
  const Folder folder;
  const auto file = folder.path() / "run.mcap";
  Samples samples;
  std::map<std::string, int> written;
  {
    Recording recording(file);
    for (std::uint64_t seq = 1; seq <= 3; ++seq) {
      wire::for_each_topic([&](const auto& kind) {
        auto sample = plain<std::decay_t<decltype(kind)>>();
        sample.header = {7, seq, static_cast<std::int64_t>(100'000'000 * seq)};
        recording.add(sample);
        samples.add(sample);
        if (is_recorded(wire::topic<std::decay_t<decltype(kind)>>()))
          ++written[wire::topic<std::decay_t<decltype(kind)>>().name];
      });
    }
    recording.attach(kScenarioAttachment, "application/yaml", "name: a\n");
    recording.add_metadata(kRunMetadata, {{"seed", "3"}});
    recording.finish();
  }
  CHECK(written.count("sim/tick") == 0);
  CHECK(written.count("fault/inject") == 1);
  Ears ears;
  const Contents contents = play(file, ears);
  CHECK(contents.ending.whole);
  CHECK(ears.heard == written);
  CHECK(ears.samples.log_hash() == samples.log_hash());
  CHECK(ears.samples.series().state.size() == 3);
  CHECK(contents.refused.empty());
  CHECK(contents.other.empty());
  CHECK(contents.attachments.at("scenario.yaml") == "name: a\n");
  CHECK(contents.metadata.at("run").at("seed") == "3");
}

TEST_CASE("recording: messages that are no samples, and topics of others, are told and left out") {
  const Folder folder;
  const auto file = folder.path() / "strange.mcap";
  {
    mcap::Writer writer(file, "", "test");
    const auto plan_type = writer.add_schema("c3rt::v2::Plan", "omgidl", "");
    const auto old_type = writer.add_schema("c3rt::v1::RobotState", "omgidl", "");
    const auto plan = writer.add_channel(plan_type, "plan", "cdr");
    const auto state = writer.add_channel(old_type, "robot/state", "cdr");
    const auto image = writer.add_channel(0, "camera/image", "jpeg");
    auto impossible = plain<wire::Plan>();
    impossible.knot_count = 1000;
    wire::Bytes bytes;
    wire::to_cdr(impossible, bytes);
    const std::uint8_t junk[3] = {1, 2, 3};
    writer.write({plan, 1, 0, 0, bytes.data(), bytes.size()});
    writer.write({plan, 2, 0, 0, junk, sizeof junk});
    writer.write({state, 1, 0, 0, junk, sizeof junk});
    writer.write({image, 1, 0, 0, junk, sizeof junk});
    writer.finish();
  }
  Ears ears;
  const Contents contents = play(file, ears);
  CHECK(ears.heard.empty());
  CHECK(contents.refused == std::map<std::string, std::uint64_t>{{"plan", 2}});
  CHECK(contents.other.at("robot/state") == "c3rt::v1::RobotState in cdr");
  CHECK(contents.other.at("camera/image") == "no topic of this contract");
}

TEST_CASE("recording: its tables have a row for each sample of the topics that are wanted") {
  const Folder folder;
  {
    Recording recording(folder.path() / "run.mcap");
    auto state = plain<wire::RobotState>();
    for (int i = 0; i < 5; ++i) recording.add(state);
    recording.add(plain<wire::Plan>());
    recording.finish();
  }
  write_csv(folder.path() / "run.mcap", {"robot/state"}, folder.path());
  std::ifstream table(folder.path() / "robot_state.csv");
  int lines = 0;
  for (std::string line; std::getline(table, line);) ++lines;
  CHECK(lines == 1 + 5);
  CHECK_FALSE(std::filesystem::exists(folder.path() / "plan.csv"));
}

}  // namespace
