#pragma once
// What becomes of the samples of a run, whether they come from the bus or from a recording: the
// series of its report, the hash, the last words of each process.
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "cli/recording/hash.hpp"
#include "cli/report/series.hpp"
#include "idl/topics.hpp"

namespace c3rt::cli {

/// The newest of each process.
using Services = std::array<std::optional<wire::ServiceStatus>, wire::kProcessCount>;

class Samples {
 public:
  /// @param scratch folder that takes what of the series is too long for the memory; empty: none
  explicit Samples(const std::filesystem::path& scratch = {}) : series_(scratch) {}

  /// In the order of each topic; those of different topics in any order.
  template <typename T>
  void add(const T& sample) {
    if constexpr (wire::topic<T>().stream != wire::kNoStream)
      visit_sample(sample, hashes_[static_cast<std::size_t>(wire::topic<T>().stream)]);
    keep(sample);
  }

  const Series& series() const { return series_; }
  const Services& words() const { return words_; }
  /// Of all streams.
  std::string log_hash() const;
  /// Forgets the series alone: the hash and the words are of all that came.
  void begin_again() { series_ = Series(series_.folder); }

 private:
  template <typename T>
  void keep(const T&) {}  // of no use for a report
  void keep(const wire::Scene& sample);
  void keep(const wire::RobotState& sample);
  void keep(const wire::RobotCommand& sample);
  void keep(const wire::Plan& sample);
  void keep(const wire::ObjectEstimate& sample);
  void keep(const wire::ServiceStatus& sample);

  Series series_;
  std::array<HashVisitor, c3rt_v2_TOPIC_COUNT> hashes_;
  Services words_;
};

}  // namespace c3rt::cli
