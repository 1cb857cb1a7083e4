#pragma once
// `c3rt bench`: the benchmark programs of the build tree.
#include <string>
#include <vector>

namespace c3rt::cli {

struct BenchSettings {
  std::string name = "c3";  // one of bench_names()
  std::string filter;       // regular expression of the benchmarks to run; empty: all
  int repetitions = 1;      // more than 1: the table shows mean, median and deviation
  std::string json;         // file of the results, beside the table; empty: none
};

std::vector<std::string> bench_names();

/// Becomes the benchmark program, which prints its table: returns only by throwing.
/// @throws UsageError where the program has not been built, or the file cannot be written
[[noreturn]] void bench(const BenchSettings& settings);

}  // namespace c3rt::cli
