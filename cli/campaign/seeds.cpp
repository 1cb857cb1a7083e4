#include "cli/campaign/seeds.hpp"

#include <charconv>
#include <set>

#include "cli/paths.hpp"

namespace c3rt::cli::campaign {
namespace {

constexpr std::size_t kMost = 100000;

[[noreturn]] void refuse(const std::string& text, const std::string& why) {
  throw UsageError("--seeds \"" + text + "\": " + why +
                   "; expected whole numbers and ranges such as 1..50 or 1,5,9..12");
}

std::uint64_t parse_seed(const std::string& word, const std::string& text) {
  std::uint64_t seed = 0;
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, seed);
  if (word.empty() || error != std::errc() || stop != end)
    refuse(text, "\"" + word + "\" is no seed");
  return seed;
}

}  // namespace

std::vector<std::uint64_t> parse_seeds(const std::string& text) {
  std::vector<std::uint64_t> seeds;
  std::set<std::uint64_t> known;
  const auto add = [&](std::uint64_t seed) {
    if (!known.insert(seed).second) refuse(text, "seed " + std::to_string(seed) + " comes twice");
    if (seeds.size() == kMost) refuse(text, "more than " + std::to_string(kMost) + " seeds");
    seeds.push_back(seed);
  };
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t comma = std::min(text.find(',', from), text.size());
    const std::string word = text.substr(from, comma - from);
    const std::size_t dots = word.find("..");
    const std::uint64_t first = parse_seed(word.substr(0, dots), text);
    const std::uint64_t last =
        dots == std::string::npos ? first : parse_seed(word.substr(dots + 2), text);
    if (last < first) refuse(text, "\"" + word + "\" runs backwards");
    for (std::uint64_t seed = first;; ++seed) {
      add(seed);
      if (seed == last) break;
    }
    from = comma + 1;
  }
  return seeds;
}

}  // namespace c3rt::cli::campaign
