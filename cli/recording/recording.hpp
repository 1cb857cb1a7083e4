#pragma once
// A run in one file: every sample as it crossed the network, in an MCAP that other tools read, with
// what it was a run of.
#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include "cli/recording/listener.hpp"
#include "cli/recording/mcap.hpp"
#include "idl/cdr.hpp"
#include "idl/topics.hpp"

namespace c3rt::cli {

constexpr const char* kRecordingName = "run.mcap";            // in the folder of a run
constexpr const char* kScenarioAttachment = "scenario.yaml";  // whole, with nothing that it extends
constexpr const char* kReportAttachment = "report.json";
constexpr const char* kRunMetadata = "run";  // "scenario", "file", "overrides", "seed", "clock"
constexpr const char* kResultMetadata = "result";  // "result", "real_time_factor"

/// Whether a topic is recorded: all but what keeps simulated time.
constexpr bool is_recorded(const wire::Topic& topic) { return topic.qos != wire::Qos::kSync; }

/// Writes. Time of a message is the sample's: of the session's clock, simulated in lockstep.
class Recording {
 public:
  /// @throws mcap::Error
  explicit Recording(const std::filesystem::path& file);

  /// @throws mcap::Error where the disk has no room
  template <typename T>
  void add(const T& sample) {
    if constexpr (is_recorded(wire::topic<T>())) {
      wire::to_cdr(sample, bytes_);
      write(wire::table::PlaceOf<T>::value, sample.header);
    }
  }
  void attach(const std::string& name, const std::string& media_type, const std::string& data);
  void add_metadata(const std::string& name, const mcap::Texts& texts);
  /// The file is whole.
  void finish();

  std::uint64_t samples() const { return writer_.messages(); }
  std::uint64_t bytes() const { return writer_.bytes(); }

 private:
  void write(int place, const wire::Header& header);

  mcap::Writer writer_;
  std::array<std::uint16_t, wire::table::kCount> channels_{};  // by place in the table
  wire::Bytes bytes_;
};

/// What a recording has besides samples.
struct Contents {
  std::map<std::string, std::uint64_t> samples;    // by topic
  std::map<std::string, std::uint64_t> refused;    // by topic: no such sample, or impossible
  std::map<std::string, std::string> other;        // topics that are not of this contract: why
  std::map<std::string, std::string> attachments;  // by name
  std::map<std::string, mcap::Texts> metadata;     // by name
  mcap::Ending ending;
};

/// Plays a recording from its beginning to its end, or to where it is cut off.
/// @throws mcap::Error if it is none
Contents play(const std::filesystem::path& file, Listener& listener);
/// The same of bytes.
Contents play_bytes(std::string_view bytes, Listener& listener);

}  // namespace c3rt::cli
