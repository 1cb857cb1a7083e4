"""Figures 11, 14 and 17: one object on the circle."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Dict

from ..groups import Group
from ..reproduction import Reproduction, tell_table
from ..statistics import mean
from ..tables import figure, loop_times, mean_loop_time, number, read_columns, spread
from ..text_table import shown, shortest
from .paths import CORNERS, OBJECT, draw_paths, read_series, results_of


@dataclass(frozen=True)
class Side:
    name: str
    scenario: str
    title: str
    paper_loop_s: float  # a circle
    paper_band: float  # share of the time in the 2 cm band


SIDES = (Side("slow", "circle_slow", "slow, no noise", 30.0, 1.0), Side("fast", "circle_fast", "fast, 1 mm noise", 21.0, 0.75))


def fig11(reproduction: Reproduction) -> None:
    """Slow without noise, fast with 1 mm of it."""
    runs = reproduction.runs([Group(side.name, side.scenario, logs=True, in_process=True) for side in SIDES])
    rows = [["", "slow", "paper", "fast", "paper"], ["circles"], ["seconds a circle"], ["in the 2 cm band [%]"],
            ["in a 1 cm band [%]"], ["ball to path, rms [mm]"], ["ball to path, largest [mm]"],
            ["end effector error, p95 [mm]"], ["end effector error, largest [mm]"], ["planner [Hz]"], ["solve time, p50 [ms]"]]
    results: Dict[str, Any] = {"what": "fig11"}
    for side, run in zip(SIDES, runs):
        report = run.report
        column = [
            (_value(report, "loops_completed", 1), "-"),
            (loop_times(report), shortest(side.paper_loop_s)),
            (_value(report, "objects.0.in_band_2cm", 100), shortest(100.0 * side.paper_band)),
            (_value(report, "objects.0.in_band_1cm", 100), "-"),
            (_value(report, "objects.0.rms_error_m", 1e3), "-"),
            (_value(report, "objects.0.max_error_m", 1e3), "-"),
            (_value(report, "end_effector.tracking_error_m.p95", 1e3), "-"),
            (_value(report, "end_effector.tracking_error_m.max", 1e3), "< 3 (hardware)"),
            (_value(report, "planner.rate_hz", 1), "73"),
            (_value(report, "planner.solve_time_s.p50", 1e3), "-"),
        ]
        for row, cells in zip(rows[1:], column):
            row.extend(cells)
        results[side.name] = {"paper": {"loop_time_s": side.paper_loop_s, "in_band_2cm": side.paper_band}, **results_of(run)}
    tell_table("Figure 11: one ball on the circle of 0.1 m, lockstep, seed 1; the paper: simulation in Drake", rows)
    reproduction.finish(results, draw_paths(reproduction, "Figure 11: one ball on the circle",
                                            [(side.title, run) for side, run in zip(SIDES, runs)]))


PAPER_LIMIT_M = 0.003  # "consistently lower than"
FROM_S, UNTIL_S = 1.0, 21.0  # what is drawn, since the begin of the task
AXES = (("x", "#d04020"), ("y", "#1b7837"), ("z", "#1f5fd0"))
PLACE = [f"{axis}_m" for axis, _ in AXES]
DESIRED = [f"desired_{axis}_m" for axis, _ in AXES]


def fig14(reproduction: Reproduction) -> None:
    """How well the end effector follows C3, in the experiment with vision."""
    run = reproduction.runs([Group("vision", "circle_vision", logs=True, in_process=True)])[0]
    track = read_columns(reproduction.series(run) / "end_effector.csv", ["t_s", *PLACE, *DESIRED])
    rows = [index for index, time in enumerate(track["t_s"]) if time >= FROM_S]
    if not rows:
        raise RuntimeError(f"{run.folder}: no command tracks a plan after the first second of the task")
    errors = [math.sqrt(sum((track[place][index] - track[wanted][index])**2 for place, wanted in zip(PLACE, DESIRED)))
              for index in rows]
    share = sum(error < PAPER_LIMIT_M for error in errors) / len(errors)
    measured = spread(errors)
    tell_table(f"Figure 14: the end effector's tracking error in circle_vision, lockstep, seed 1, from {FROM_S:g} s after the begin "
               "of the task; the paper: hardware",
               [["", "here", "paper"],
                ["error, p50 [mm]", shown(1e3 * measured["p50"]), "-"],
                ["error, p95 [mm]", shown(1e3 * measured["p95"]), "-"],
                ["error, p99 [mm]", shown(1e3 * measured["p99"]), "-"],
                ["error, largest [mm]", shown(1e3 * measured["max"]), "< 3"],
                ["below 3 mm [% of the time]", shown(100.0 * share), "100"]])
    drawn = [(index, error) for index, error in zip(rows, errors) if track["t_s"][index] <= UNTIL_S]
    times = [track["t_s"][index] for index, _ in drawn]
    upper = {"y_label": "end effector to x_d [mm]", "curves": [
        {"name": "|error|", "color": "#1f5fd0", "x": times, "y": [1e3 * error for _, error in drawn]},
        {"name": "3 mm: the paper's bound", "color": "#d04020", "x": [FROM_S, times[-1]], "y": [1e3 * PAPER_LIMIT_M] * 2,
         "line": "dashed"}]}
    lower = {"x_label": "time [s]", "y_label": "x_d of C3 [m]", "curves": [
        {"name": name, "color": color, "x": times, "y": [track[wanted][index] for index, _ in drawn]}
        for (name, color), wanted in zip(AXES, DESIRED)]}
    told = results_of(run)
    reproduction.finish({"what": "fig14", "command": told["command"], "paper": {"bound_m": PAPER_LIMIT_M},
                         "tracking_error_m": measured, "share_below_3mm": share, "report": told["report"]},
                        {"title": "Figure 14: end effector tracking error and desired locations", "panels": [upper, lower]})


def fig17(reproduction: Reproduction) -> None:
    """With three cameras, over several rounds."""
    run = reproduction.runs([Group("vision", "circle_vision", overrides=["task.loops=5", "task.duration_s=240"], logs=True,
                                   in_process=True)])[0]
    report = run.report
    objects, corners = read_series(reproduction.series(run))
    # the last corner of a closed path is the first one again
    offset = [mean(objects[place]) - mean(corners[corner][:-1]) for place, corner in zip(OBJECT, CORNERS)]
    mean_time = mean_loop_time(report)
    tell_table("Figure 17: the circle with three rendered cameras, lockstep, seed 1; the paper: hardware, on a table slightly tilted",
               [["", "here", "paper"],
                ["circles", _value(report, "loops_completed", 1), "-"],
                ["seconds a circle", loop_times(report), ""],
                ["mean seconds a circle", shown(mean_time), "35"],
                ["in the 2 cm band [%]", _value(report, "objects.0.in_band_2cm", 100), "-"],
                ["ball to path, rms [mm]", _value(report, "objects.0.rms_error_m", 1e3), "-"],
                ["ball to path, largest [mm]", _value(report, "objects.0.max_error_m", 1e3), "nearly 50"],
                ["mean of the path from its centre, x [mm]", shown(1e3 * offset[0]), "-"],
                ["mean of the path from its centre, y [mm]", shown(1e3 * offset[1]), "> 0"],
                ["vision [Hz]", _value(report, "vision.rate_hz", 1), "80 to 90"],
                ["vision error, p95 [mm]", _value(report, "vision.error_m.p95", 1e3), "1"],
                ["planner [Hz]", _value(report, "planner.rate_hz", 1), "70 to 80"]])
    told = results_of(run)
    reproduction.finish({"what": "fig17", "command": told["command"],
                         "paper": {"loop_time_s": 35.0, "max_error_m": 0.05, "vision_error_m": 0.001},
                         "mean_loop_time_s": number(mean_time), "mean_offset_m": offset, "report": told["report"]},
                        draw_paths(reproduction, "Figure 17: the circle with three cameras", [("", run)]))


def _value(report: Any, path: str, factor: float) -> str:
    return shown(factor * figure(report, path))
