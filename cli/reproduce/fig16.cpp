// Figure 16: the object on three paths in time.
#include <fmt/format.h>

#include "cli/reproduce/timed_paths.hpp"

namespace c3rt::cli::reproduce {

void fig16(const Context& context) {
  const auto runs = timed_path_runs(context);
  std::vector<PathPlot> plots;
  for (std::size_t i = 0; i < runs.size(); ++i)
    plots.push_back(path_plot(kTimedPaths[i].name, runs[i]));
  fmt::print(
      "Figure 16: paths in time with three rendered cameras, lockstep, seed 1; the paper: "
      "hardware\n\n");
  print_table(timed_path_rows(runs));
  context.finish(timed_path_results("fig16", runs),
                 draw_paths(context.picture(), "Figure 16: paths in time", plots));
}

}  // namespace c3rt::cli::reproduce
