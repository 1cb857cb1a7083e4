"""Figures 16 and 18: the object on three paths in time, with three cameras."""

from __future__ import annotations

from typing import Any, Dict, List, Sequence, Tuple

from ..groups import Group
from ..reproduction import Reproduction, tell_table
from ..runs import RunResult
from ..tables import figure
from ..text_table import shown
from .paths import BAND_M, draw_paths, read_series, results_of

PATHS = (("circle", "path_circle"), ("line", "path_line"), ("rectangle", "path_rectangle"))
# of a report, after the first second; the paper gives no numbers but the band of its figures
ROWS: Sequence[Tuple[str, str, float, Sequence[str]]] = (
    ("to x_d(t), rms [mm]", "judged.rms_error_m", 1e3, ()),
    ("to x_d(t), 95 % [mm]", "judged.p95_error_m", 1e3, ()),
    ("to x_d(t), largest [mm]", "judged.max_error_m", 1e3, ["about 20"]),
    ("within 2 cm of x_d(t) [%]", "judged.in_band_2cm", 1e2, ()),
    ("to the held way-points, rms [mm]", "path.to_held_points.rms_error_m", 1e3, ()),
    ("to the held way-points, largest [mm]", "path.to_held_points.max_error_m", 1e3, ()),
    ("end effector error, p95 [mm]", "end_effector.tracking_error_m.p95", 1e3, ["< 3 (VII-C)"]),
    ("vision error, p95 [mm]", "vision.error_m.p95", 1e3, ["1"]),
)
MOVING, HELD = "object_0_to_interpolated_path_m", "object_0_to_held_points_m"


def fig16(reproduction: Reproduction) -> None:
    """Seen from above."""
    runs = _runs(reproduction)
    tell_table("Figure 16: paths in time with three rendered cameras, lockstep, seed 1; the paper: hardware", _rows(runs))
    reproduction.finish(_results("fig16", runs),
                        draw_paths(reproduction, "Figure 16: paths in time", [(name, run) for (name, _), run in zip(PATHS, runs)]))


def fig18(reproduction: Reproduction) -> None:
    """The error over time."""
    runs = _runs(reproduction)
    tell_table("Figure 18: error of the ball on paths in time with three rendered cameras, lockstep, seed 1; the paper: hardware",
               [*_rows(runs), [""],
                ["x_d(t) moves between the way-points at constant speed; held way-points jump by 20 to 40 mm, and a ball that"],
                ["moves steadily is up to that far from them."]])
    panels = [_panel(reproduction, name, run) for (name, _), run in zip(PATHS, runs)]
    panels[-1]["x_label"] = "time since C3 took over [s]"
    reproduction.finish(_results("fig18", runs), {"title": "Figure 18: error on paths in time", "panels": panels})


def _runs(reproduction: Reproduction) -> List[RunResult]:
    return reproduction.runs([Group(name, scenario, overrides=["vision.source=cameras"], logs=True, in_process=True)
                              for name, scenario in PATHS])


def _rows(runs: Sequence[RunResult]) -> List[List[str]]:
    rows = [["after the first second", *(name for name, _ in PATHS), "paper"]]
    for label, path, factor, paper in ROWS:
        rows.append([label, *(shown(factor * figure(run.report, path)) for run in runs), *paper])
    return rows


def _results(what: str, runs: Sequence[RunResult]) -> Dict[str, Any]:
    return {"what": what, "paper": {"band_m": BAND_M}, **{name: results_of(run) for (name, _), run in zip(PATHS, runs)}}


def _panel(reproduction: Reproduction, name: str, run: RunResult) -> Dict[str, Any]:
    """The error to the desired point of the time, and to the way-point that is held then."""
    objects, _ = read_series(reproduction.series(run), [MOVING, HELD])
    time = objects["t_s"]
    return {"title": name, "y_label": "error [mm]", "curves": [
        {"name": "to the held way-point", "color": "#c8c8c8", "x": time, "y": [1e3 * error for error in objects[HELD]]},
        {"name": "to x_d(t)", "color": "#1f5fd0", "x": time, "y": [1e3 * error for error in objects[MOVING]]},
        {"name": "2 cm", "color": "#d04020", "x": [0.0, time[-1]], "y": [1e3 * BAND_M] * 2, "line": "dashed"}]}
