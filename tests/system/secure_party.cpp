// Somebody on the bus who reads and writes every topic as far as that is possible, for a few
// seconds, and says how far that was: a line "TOPIC READ MET" for each, with the samples that
// arrived from others and the readers of others that its writer met; "-" where its own rights do not let it try.
//   secure_party DOMAIN PROFILE IDENTITY SECONDS
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "controller/rt/periodic_clock.hpp"
#include "idl/dds.hpp"

namespace {

using namespace c3rt;

/// On one topic.
class Attempt {
 public:
  virtual ~Attempt() = default;
  virtual void step() = 0;
  virtual void tell() const = 0;
};

template <typename T>
class AttemptOn : public Attempt {
 public:
  explicit AttemptOn(wire::Bus& bus) {
    try {
      reader_ = std::make_unique<wire::Reader<T>>(bus);
    } catch (const wire::WireError&) {
    }
    try {
      writer_ = std::make_unique<wire::Writer<T>>(bus);
    } catch (const wire::WireError&) {
    }
    // it would read what it writes itself
    if (std::is_same_v<T, wire::RobotCommand> && writer_) reader_.reset();
  }
  void step() override {
    T sample{};
    while (reader_ && reader_->take(sample)) ++read_;
    // the only one that would be obeyed without a word: as much torque as the joint takes
    if constexpr (std::is_same_v<T, wire::RobotCommand>) {
      sample = {};
      sample.tau_nm[0] = 87.0;
      if (writer_) writer_->write(sample, rt::now_ns());
    }
    // but its own
    if (writer_) met_ = std::max(met_, writer_->matched_readers() - (reader_ ? 1 : 0));
  }
  void tell() const override {
    std::printf("%s %s %s\n", wire::topic<T>().name,
                reader_ ? std::to_string(read_).c_str() : "-",
                writer_ ? std::to_string(met_).c_str() : "-");
  }

 private:
  std::unique_ptr<wire::Reader<T>> reader_;
  std::unique_ptr<wire::Writer<T>> writer_;
  long read_ = 0;
  int met_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) return 2;
  try {
    wire::BusSettings settings;
    settings.domain = static_cast<std::uint32_t>(std::atoi(argv[1]));
    settings.profile_uri = argv[2];
    settings.identity = argv[3];
    settings.clock = wire::ClockMode::kLockstep;
    wire::Bus bus(settings);
    std::vector<std::unique_ptr<Attempt>> attempts;
    wire::for_each_topic([&](const auto& sample) {
      attempts.push_back(std::make_unique<AttemptOn<std::decay_t<decltype(sample)>>>(bus));
    });
    const std::int64_t end_ns = rt::now_ns() + std::atoi(argv[4]) * std::int64_t{1'000'000'000};
    while (rt::now_ns() < end_ns) {
      for (const auto& attempt : attempts) attempt->step();
      bus.wait_for_data(5'000'000);
    }
    for (const auto& attempt : attempts) attempt->tell();
    return 0;
  } catch (const std::exception& error) {
    std::printf("refused: %s\n", error.what());
    return 1;
  }
}
