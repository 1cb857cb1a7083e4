#pragma once
// CMA-ES, by the package cmaes of Python: candidates of a generation from the ranks of those
// before.
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace c3rt::cli::tune {

struct Generation {
  std::vector<Eigen::VectorXd> candidates;  // in [0, 1]
  std::vector<double> ranks;                // of each, less is better
};

struct Search {
  Eigen::VectorXd mean;  // where it begins, in [0, 1]; two numbers at least
  double sigma;          // how far from there the first generation is drawn
  std::uint32_t seed;
  int population;
};

/// 4 + 3 ln n, as Hansen advises.
int usual_population(int parameters);

/// @param python that has cmaes
/// @return the next generation's candidates: of the same history always the same
/// @throws std::runtime_error saying what failed
std::vector<Eigen::VectorXd> next_candidates(const std::string& python, const Search& search,
                                             const std::vector<Generation>& history);

}  // namespace c3rt::cli::tune
