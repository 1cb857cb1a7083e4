// Table I: finger gaiting, s = 5, ρ = 1, ρ_s = 1.01, cost over 2 s.
#include "cli/reproduce/horizon_table.hpp"

namespace c3rt::cli::reproduce {

void table1(const Context& context) {
  const HorizonTable table{
      "Table I: finger gaiting, 2 s from [-8 0 3 0 4 0]",
      "finger_gaiting",
      {"control.duration_s=2", "c3.admm_iterations=5", "c3.rho=1", "c3.rho_scale=1.01",
       "c3.start=fresh", "start.x0=[-8, 0, 3, 0, 4, 0]", "start.spread_min=[0, 0, 0, 0, 0, 0]",
       "start.spread_max=[0, 0, 0, 0, 0, 0]"},
      // tried at N = 10: s 5, 10, 20; ρ 0.1, 1, 10; ρ_s 1.01, 1.2, 1.5, 2; the last solution
      // shifted; then at all N: s 20 … 40 with ρ 1 … 10. More iterations help most; ρ 1 and
      // ρ_s 1.05 … 1.1 are good at every N, others only at some
      {"c3.admm_iterations=20", "c3.rho_scale=1.05"},
      "own settings (s = 20, ρ_s = 1.05)",
      true,
      1e7,
      // the paper; the authors' code on one core of a 2-core machine: its OSQP and Gurobi alone,
      // and its MIQP at the one horizon that Gurobi's free licence allows
      {{"paper: C3", {"25", "51", "67", "95"}},
       {"paper: MIQP", {"112", "294", "791", "2315"}},
       {"authors' code: C3, solvers alone", {"149", "276", "423", "771"}},
       {"authors' code: MIQP", {"171", "-", "-", "-"}}},
      {{"paper: C3", {"4.979", "4.248", "4.101", "9.552"}},
       {"paper: MIQP", {"3.467", "3.454", "3.451", "3.452"}},
       {"independent exact C3", {"5.476", "5.197", "5.210", "5.210"}},
       {"independent MIQP", {"3.477", "3.457", "3.455", "3.461"}}}};
  run_horizon_table(context, table);
}

}  // namespace c3rt::cli::reproduce
