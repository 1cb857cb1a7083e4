#include "cli/bench.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <unistd.h>

#include "cli/paths.hpp"

namespace c3rt::cli {

std::vector<std::string> bench_names() { return {"c3", "vision"}; }

void bench(const BenchSettings& settings) {
  const std::filesystem::path program = binary_directory() / ("c3rt_bench_" + settings.name);
  if (access(program.c_str(), X_OK) != 0) {
    throw UsageError(fmt::format(
        "bench {}: expected {}, which is not there: ./c3rt bench builds it, and no package has it",
        settings.name, program.string()));
  }
  std::vector<std::string> words{program.string()};
  if (!settings.filter.empty()) words.emplace_back("--benchmark_filter=" + settings.filter);
  if (settings.repetitions > 1) {
    words.push_back(fmt::format("--benchmark_repetitions={}", settings.repetitions));
    words.emplace_back("--benchmark_display_aggregates_only=true");
    // what disturbs the machine for a while disturbs no benchmark alone
    words.emplace_back("--benchmark_enable_random_interleaving=true");
  }
  if (!settings.json.empty()) {
    if (!std::ofstream(settings.json, std::ios::app)) {
      throw UsageError(fmt::format("{}: expected a file that can be written", settings.json));
    }
    words.push_back("--benchmark_out=" + settings.json);
    words.emplace_back("--benchmark_out_format=json");
  }
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  execv(program.c_str(), arguments.data());
  throw std::runtime_error(
      fmt::format("bench {}: {}: {}", settings.name, program.string(), std::strerror(errno)));
}

}  // namespace c3rt::cli
