// The scenario readers: any text, with any overrides, gives a ConfigError or a scenario. Lines that
// begin with "#set " are the overrides.
#include <cstddef>
#include <cstdint>
#include <sstream>
#include <string>
#include <vector>

#include "config/scenario.hpp"
#include "controller/example/load_experiment.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace c3rt;
  const std::string text(reinterpret_cast<const char*>(data), size), mark = "#set ";
  std::vector<std::string> overrides;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.compare(0, mark.size(), mark) == 0) overrides.push_back(line.substr(mark.size()));
  }
  try {
    config::Section root = config::Document::parse(text, "fuzz", overrides);
    if (root.has("example")) {
      (void)example::load_experiment(root);
    } else {
      (void)config::read_scenario(root);
    }
  } catch (const config::ConfigError&) {
  }
  return 0;
}
