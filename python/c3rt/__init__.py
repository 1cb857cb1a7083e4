"""Contact-implicit model predictive control: linear complementarity systems and C3.

Arrays have the stages first: x is (N + 1, n_x), u (N, n_u), lam (N, n_lambda). What comes in may have any strides; what
comes out shows the memory of the object that it belongs to and cannot be written to. SI units throughout.
"""

import importlib
from typing import TYPE_CHECKING, Any, List

if TYPE_CHECKING:
    from ._core import (
        LCS,
        Iterate,
        MjcfLcs,
        PlanningModel,
        Problem,
        Projected,
        Result,
        SamplingPlan,
        SamplingPlanner,
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
    "SamplingPlan",
    "SamplingPlanner",
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


def __getattr__(name: str) -> Any:
    """The compiled module is loaded with the first name that is used: c3rt.evaluation is at work where there is none."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module("._run" if name == "run" else "._core", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> List[str]:
    return sorted({*globals(), *__all__})
