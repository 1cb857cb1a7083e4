#include "cli/recording/mcap.hpp"

#include <cstring>
#include <fstream>
#include <random>
#include <sstream>

#include <catch2/catch.hpp>

#include "tests/cli/folder.hpp"
#include "tests/support/small_disk.hpp"

using namespace c3rt;
using c3rt::cli::Folder;

namespace {

/// All that is heard, as text.
class Heard final : public mcap::Listener {
 public:
  void hear(const mcap::Schema& schema) override {
    lines.push_back("schema " + schema.name + " " + schema.encoding + " " + schema.text);
  }
  void hear(const mcap::Channel& channel) override {
    lines.push_back("channel " + channel.topic + " " + channel.encoding + " of " +
                    std::to_string(channel.schema));
  }
  void hear(const mcap::Message& message) override {
    lines.push_back("message " + std::to_string(message.channel) + " " +
                    std::to_string(message.sequence) + " " + std::to_string(message.log_ns) + " " +
                    std::string(reinterpret_cast<const char*>(message.data), message.size));
  }
  void hear(const mcap::Attachment& attachment) override {
    lines.push_back("attachment " + attachment.name + " " + attachment.data);
  }
  void hear(const std::string& name, const mcap::Texts& metadata) override {
    lines.push_back("metadata " + name);
    for (const auto& [key, value] : metadata) lines.back() += " " + key + "=" + value;
  }
  std::vector<std::string> lines;
};

std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

void say(mcap::Writer& writer, std::uint16_t channel, std::uint32_t sequence, std::int64_t ns,
         const std::string& text) {
  writer.write(
      {channel, sequence, ns, ns, reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

/// Three chunks, as they are a second each.
void write_some(const std::filesystem::path& file, bool finish) {
  mcap::Writer writer(file, "profile", "test");
  writer.attach({"scenario.yaml", "application/yaml", "name: a"});
  const std::uint16_t schema = writer.add_schema("a::B", "omgidl", "struct B");
  const std::uint16_t first = writer.add_channel(schema, "one", "cdr");
  const std::uint16_t second = writer.add_channel(schema, "two", "cdr", {{"key", "value"}});
  for (int i = 0; i < 30; ++i) {
    say(writer, i % 3 == 0 ? second : first, static_cast<std::uint32_t>(i), 100'000'000LL * i,
        "text " + std::to_string(i));
  }
  writer.add_metadata("run", {{"seed", "7"}});
  CHECK(writer.messages() == 30);
  if (finish) writer.finish();
}

TEST_CASE("MCAP: what was written is heard again, in its order") {
  const Folder folder;
  const auto file = folder.path() / "a.mcap";
  write_some(file, true);
  Heard heard;
  const mcap::Ending ending = mcap::read(file, heard);
  CHECK(ending.whole);
  CHECK(ending.why.empty());
  REQUIRE(heard.lines.size() == 1 + 1 + 2 + 30 + 1);
  CHECK(heard.lines[0] == "attachment scenario.yaml name: a");
  CHECK(heard.lines[1] == "schema a::B omgidl struct B");
  CHECK(heard.lines[2] == "channel one cdr of 1");
  CHECK(heard.lines[3] == "channel two cdr of 1");
  CHECK(heard.lines[4] == "message 2 0 0 text 0");
  CHECK(heard.lines[33] == "message 1 29 2900000000 text 29");
  CHECK(heard.lines[34] == "metadata run seed=7");
}

TEST_CASE("MCAP: of a file that a crash left all whole chunks are heard") {
  const Folder folder;
  const auto whole = folder.path() / "whole.mcap", left = folder.path() / "left.mcap";
  write_some(whole, true);
  write_some(left, false);
  Heard all, some;
  mcap::read(whole, all);
  const mcap::Ending ending = mcap::read(left, some);
  CHECK_FALSE(ending.whole);
  CHECK(ending.why == "it is cut off");
  CHECK(some.lines == all.lines);  // the metadata ended the last chunk

  // and wherever it is cut, what is heard is the beginning of the whole
  const std::string bytes = bytes_of(whole);
  std::size_t heard = 0;
  for (std::size_t size = 8; size < bytes.size(); ++size) {
    Heard part;
    const mcap::Ending cut = mcap::read_bytes(std::string_view(bytes).substr(0, size), part);
    REQUIRE(part.lines.size() <= all.lines.size());
    REQUIRE(std::equal(part.lines.begin(), part.lines.end(), all.lines.begin()));
    REQUIRE(part.lines.size() >= heard);
    heard = part.lines.size();
    if (cut.whole) REQUIRE(heard == all.lines.size());
  }
  CHECK(heard == all.lines.size());
}

TEST_CASE("MCAP: a file that is damaged is read up to there, and no other bytes do harm") {
  const Folder folder;
  const auto file = folder.path() / "a.mcap";
  write_some(file, true);
  Heard all;
  mcap::read(file, all);
  const std::string bytes = bytes_of(file);
  std::mt19937 random(1);
  int damaged = 0;
  for (int i = 0; i < 3000; ++i) {
    std::string changed = bytes;
    for (int j = 0; j < 1 + i % 4; ++j)
      changed[8 + random() % (changed.size() - 8)] = static_cast<char>(random());
    Heard heard;
    const mcap::Ending ending = mcap::read_bytes(std::string_view(changed), heard);
    REQUIRE(ending.whole == ending.why.empty());
    damaged += ending.whole ? 0 : 1;
  }
  CHECK(damaged > 1000);
  CHECK_THROWS_WITH(mcap::read_bytes(std::string_view("name: circle_slow"), all),
                    "it does not begin as an MCAP does");
  CHECK_THROWS_WITH(mcap::read(folder.path() / "none.mcap", all),
                    Catch::Contains("none.mcap: No such file"));
}

TEST_CASE("MCAP: a file that is there is not written over") {
  const Folder folder;
  std::ofstream(folder.path() / "a.mcap") << "dear";
  CHECK_THROWS_WITH(mcap::Writer(folder.path() / "a.mcap", "", "test"),
                    Catch::Contains("a.mcap: File exists"));
  CHECK(bytes_of(folder.path() / "a.mcap") == "dear");
}

TEST_CASE("MCAP: a disk without room is told, and told again") {
  const test::SmallDisk disk;
  if (!disk.mounted()) {
    WARN("no file system can be mounted here");
    return;
  }
  mcap::Writer writer(disk.path() / "a.mcap", "", "test");
  const std::uint16_t channel = writer.add_channel(0, "one", "cdr");
  std::mt19937_64 random(1);
  const auto fill = [&] {
    std::string text(1 << 16, ' ');
    for (int i = 0; i < 4000; ++i) {
      for (std::size_t at = 0; at < text.size(); at += 8) {
        const std::uint64_t number = random();
        std::memcpy(text.data() + at, &number, 8);
      }
      say(writer, channel, static_cast<std::uint32_t>(i), i, text);
    }
  };
  CHECK_THROWS_WITH(fill(), Catch::Contains("a.mcap: No space left on device"));
  CHECK_THROWS_AS(say(writer, channel, 1, 1, "more"), mcap::Error);
}

}  // namespace
