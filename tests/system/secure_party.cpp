// Somebody on the bus who reads and writes every topic as far as that is possible, until it is
// asked to end, or until something came of each topic that it names, and says how far that was: a
// line "TOPIC READ MET" for each, with the samples that arrived from others and the readers of
// others that its writer met; "-" where its own rights do not let it try.
//   secure_party DOMAIN PROFILE IDENTITY [TOPIC...]
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <memory>
#include <set>
#include <string>
#include <type_traits>
#include <vector>

#include "controller/rt/periodic_clock.hpp"
#include "idl/dds.hpp"
#include "idl/process.hpp"

namespace {

using namespace c3rt;

constexpr std::int64_t kPatience_ns = 60'000'000'000;

/// On one topic.
class Attempt {
 public:
  virtual ~Attempt() = default;
  virtual std::string topic() const = 0;
  virtual bool succeeded() const = 0;
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
  std::string topic() const override { return wire::topic<T>().name; }
  bool succeeded() const override { return reader_ && writer_ ? met_ > 0 : read_ > 0 || met_ > 0; }
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
    std::printf("%s %s %s\n", wire::topic<T>().name, reader_ ? std::to_string(read_).c_str() : "-",
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
  if (argc < 4) return 2;
  const wire::StopFlag stop;
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
    const std::set<std::string> wanted(argv + 4, argv + argc);
    const auto done = [&] {
      return !wanted.empty() &&
             std::all_of(attempts.begin(), attempts.end(), [&](const auto& attempt) {
               return wanted.count(attempt->topic()) == 0 || attempt->succeeded();
             });
    };
    const std::int64_t end_ns = rt::now_ns() + kPatience_ns;
    while (rt::now_ns() < end_ns && !wire::StopFlag::requested() && !done()) {
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
