"""Objects from anywhere to a goal pose with sampled places.

No table of the C3 paper, but what its successors publish [Push Anything, arXiv 2510.19974; push T on hardware, its plotting
script].
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import List, Sequence

from ..groups import Group
from ..reproduction import Reproduction, tell_table
from ..runs import RunResult
from ..statistics import is_number, quantile, wilson
from ..status import DONE
from ..text_table import shown


@dataclass(frozen=True)
class Case:
    scenario: str
    label: str
    overrides: List[str] = field(default_factory=list)  # what the plant or the sensing has apart from the plan
    published: str = "-"  # seconds to a goal, of others


CASES = (
    Case("push_box", "box"),
    Case("push_t", "T", published="mean 26.9, median 22.8"),
    Case("push_l", "L"),
    Case("push_h", "H"),
    Case("push_e", "E"),
    Case("push_t_cameras", "T, three cameras", published="mean 26.9, median 22.8"),
    Case("jack", "jack"),
    Case("cone_and_ball", "cone and ball"),
    Case("two_objects", "two objects", published="mean 96"),
    Case("three_objects", "three objects", published="mean 192"),
    Case("four_objects", "four objects", published="mean 318"),
    Case("push_t", "T, friction 0.2 on the table", ["plant.objects.0.friction_table=0.2"]),
    Case("push_t", "T, friction 0.8 on the table", ["plant.objects.0.friction_table=0.8"]),
    Case("push_t", "T, plan with half the mass", ["planner.model.mass_scale=0.5"]),
    Case("push_t", "T, plan with twice the mass", ["planner.model.mass_scale=2"]),
    Case("push_t", "T, plan 10 % smaller", ["planner.model.size_scale=0.9"]),
    Case("push_t", "T, plan 10 % larger", ["planner.model.size_scale=1.1"]),
    Case("push_t", "T, noise of 3 mm and 1 degree", ["vision.emulated.noise_m=0.003", "vision.emulated.angle_noise_rad=0.0175"]),
    Case("push_t", "T, plans 20 ms late", ["timing.solve_time_s=0.02"]),
)
HEAD = ["", "reached", "share, 95 % interval [%]", "time, median; 95 % [s]", "end, median; 95 % [mm]", "and [deg]", "published [s]"]


def push_anything(reproduction: Reproduction) -> None:
    settings = reproduction.settings
    cases = CASES[:2] if settings.quick else CASES
    groups = [Group(f"{index:02}-{case.scenario}", case.scenario, settings.seeds, case.overrides, in_process=True)
              for index, case in enumerate(cases)]
    rows, told = [HEAD], []
    for case, runs in zip(cases, reproduction.groups(groups)):
        reached = sum(run.status == DONE for run in runs)
        share = wilson(reached, len(runs))
        times = _of_runs(runs, "goal_time_s", 1.0)
        ends = _of_runs(runs, "end_position_error_m", 1e3)
        turns = _of_runs(runs, "end_angle_error_rad", 180.0 / math.pi)
        rows.append([case.label, f"{reached} of {len(runs)}", f"{100 * share.low:.0f} to {100 * share.high:.0f}",
                     _median_and_95(times), _median_and_95(ends), _median_and_95(turns), case.published])
        told.append({"case": case.label, "scenario": case.scenario, "overrides": case.overrides, "reached": reached,
                     "runs": len(runs), "goal_times_s": times, "end_position_errors_mm": ends, "end_angle_errors_deg": turns})
    tell_table(f"Objects pushed to a goal pose from anywhere, seeds {settings.seeds}: each run as its scenario judges it; times "
               "until the goal is held within the task's tolerance", rows)
    reproduction.finish({"what": "push_anything", "seeds": settings.seeds, "cases": told})


def _of_runs(runs: Sequence[RunResult], name: str, factor: float) -> List[float]:
    """Sorted, of the runs that give it."""
    found = [run.report["task"][name] for run in runs if run.report is not None]
    return sorted(factor * value for value in found if is_number(value))


def _median_and_95(values: Sequence[float]) -> str:
    """values: sorted"""
    return f"{shown(quantile(values, 0.5), 3)}; {shown(quantile(values, 0.95), 3)}" if values else "-"
