"""What the figures of section VII share: where a run's object went, and pictures of it beside its path."""

from __future__ import annotations

import pathlib
from typing import Any, Dict, List, Sequence, Tuple

from ..reproduction import Reproduction
from ..runs import RunResult, replay_command
from ..tables import Columns, read_columns

BAND_M = 0.02  # about the path, that of the paper's figures
FARTHEST_M = 0.2  # a lost object must not shrink the path to a point
MOST_POINTS = 6000  # of one line
OBJECT = ["object_0_x_m", "object_0_y_m"]
CORNERS = ["x_m", "y_m"]


def read_series(folder: pathlib.Path, more: Sequence[str] = ()) -> Tuple[Columns, Columns]:
    """Of objects.csv time, place and what more is asked for of the first object, and the path's corners."""
    objects = read_columns(folder / "objects.csv", ["t_s", *OBJECT, *more])
    if not objects["t_s"]:
        raise RuntimeError(f"{folder}: the run never began its task")
    return objects, read_columns(folder / "path.csv", CORNERS)


def results_of(run: RunResult) -> Dict[str, Any]:
    return {"command": replay_command(run.spec), "report": run.report}


def draw_paths(reproduction: Reproduction, title: str, runs: Sequence[Tuple[str, RunResult]]) -> Dict[str, Any]:
    """A figure of runs by their titles: each path with its 2 cm band, all at one scale, side by side."""
    shown = [(name, *read_series(reproduction.series(run))) for name, run in runs]
    boxes = [_box(objects, corners) for _, objects, corners in shown]
    reach = max(0.5 * max(high - low for low, high in box) + 1.5 * BAND_M for box in boxes)
    return {"title": title, "columns": len(shown),
            "panels": [_panel(name, objects, corners, [0.5 * (low + high) for low, high in box], reach)
                       for (name, objects, corners), box in zip(shown, boxes)]}


def _panel(title: str, objects: Columns, corners: Columns, centre: List[float], reach: float) -> Dict[str, Any]:
    step = len(objects["t_s"]) // MOST_POINTS + 1
    x, y = (corners[name] for name in CORNERS)
    return {
        "title": title, "x_label": "x [m]", "y_label": "y [m]", "equal": True, "legend": "below",
        "x_limits": [centre[0] - reach, centre[0] + reach], "y_limits": [centre[1] - reach, centre[1] + reach],
        "bands": [{"name": "2 cm band", "color": "#f8cfdc", "x": x, "y": y, "radius": BAND_M}],
        "curves": [
            {"name": "desired path", "color": "#1f5fd0", "x": x, "y": y, "line": "dashed"},
            {"name": "object", "color": "#000000", "x": objects[OBJECT[0]][::step], "y": objects[OBJECT[1]][::step],
             "width": 1.3},
        ]}


def _box(objects: Columns, corners: Columns) -> List[Tuple[float, float]]:
    """What is shown, in x and y."""
    box = []
    for corner, place in zip(CORNERS, OBJECT):
        low, high = min(corners[corner]), max(corners[corner])
        box.append((min(low, max(min(objects[place]), low - FARTHEST_M)),
                    max(high, min(max(objects[place]), high + FARTHEST_M))))
    return box
