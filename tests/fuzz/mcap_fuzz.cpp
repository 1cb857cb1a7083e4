// The reader of recordings behind `c3rt report` and `export`: of any bytes it hears samples that
// every reader of the bus would let in, and says where it stopped.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "cli/recording/recording.hpp"
#include "idl/validate.hpp"
#include "tests/fuzz/promise.hpp"

namespace {

using namespace c3rt;

class Ears final : public cli::Listener {
 public:
#define C3RT_TOPIC(Type, ...)                                                   \
  void hear(const wire::Type& sample) override {                                \
    require(!wire::validate(sample), "what is heard is what a reader lets in"); \
    ++heard;                                                                    \
  }
  C3RT_TOPICS(C3RT_TOPIC)
#undef C3RT_TOPIC
  std::uint64_t heard = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Ears ears;
  try {
    const cli::Contents contents =
        cli::play_bytes(std::string_view(reinterpret_cast<const char*>(data), size), ears);
    require(contents.ending.whole == contents.ending.why.empty(), "it says why it stopped");
    std::uint64_t counted = 0;
    for (const auto& [topic, count] : contents.samples) counted += count;
    require(counted == ears.heard, "what is heard is counted");
  } catch (const mcap::Error&) {
  }
  return 0;
}
