"""Contact-implicit model predictive control: linear complementarity systems and C3.

Arrays have the stages first: x is (N + 1, n_x), u (N, n_u), lam (N, n_lambda). What comes in may have any strides; what
comes out shows the memory of the object that it belongs to and cannot be written to. SI units throughout.
"""

from ._core import (
    LCS,
    Iterate,
    MjcfLcs,
    PlanningModel,
    Problem,
    Projected,
    Result,
    Simulation,
    Solver,
    System,
    lcs_from_mjcf,
    load_problem,
    planning_models,
    projections,
    simulate,
    systems,
)
from ._run import run

__all__ = [
    "LCS",
    "Iterate",
    "MjcfLcs",
    "PlanningModel",
    "Problem",
    "Projected",
    "Result",
    "Simulation",
    "Solver",
    "System",
    "lcs_from_mjcf",
    "load_problem",
    "planning_models",
    "projections",
    "run",
    "simulate",
    "systems",
]
