"""What a report tells of one closed loop of an example."""

from __future__ import annotations

from typing import Any, Dict

from ..runs import RunResult


def loop_figures(run: RunResult) -> Dict[str, Any]:
    report = run.report
    assert report is not None
    trial, times = report["trials"][0], report["solve_time_s"]
    names = ("accumulated_cost", "mean_cost_to_go", "succeeded", "controller_failures", "plant_failed", "overshoot")
    return {**{name: trial[name] for name in names}, "calls": report["solves"],
            "solve_time_s": {name: times[name] for name in ("p50", "p95", "max")}}
