"""Columns of tables, and figures of reports by their path."""

from __future__ import annotations

import csv
import math
import pathlib
from typing import Any, Dict, List, Sequence

from .statistics import is_number, mean

Columns = Dict[str, List[float]]


def read_columns(file: pathlib.Path, names: Sequence[str]) -> Columns:
    """Columns of numbers of a CSV file, NaN for an empty cell. RuntimeError naming the file and the column that is not there."""
    with file.open(newline="", encoding="utf-8") as stream:
        rows = csv.reader(stream)
        head = next(rows, [])
        for name in names:
            if name not in head:
                raise RuntimeError(f'{file}: there is no column "{name}"')
        places = [head.index(name) for name in names]
        columns: Columns = {name: [] for name in names}
        for number, row in enumerate(rows, 1):
            if len(row) != len(head):
                raise RuntimeError(f"{file}: row {number} has {len(row)} columns, expected {len(head)}")
            for name, place in zip(names, places):
                columns[name].append(float(row[place]) if row[place] else math.nan)
    return columns


def figure(report: Any, path: str) -> float:
    """figure(report, "objects.0.rms_error_m"); NaN where it is not."""
    place = report
    for name in path.split("."):
        if isinstance(place, list) and name.isdigit() and int(name) < len(place):
            place = place[int(name)]
        elif isinstance(place, dict) and name in place:
            place = place[name]
        else:
            return math.nan
    return float(place) if is_number(place) else math.nan


def loop_times(report: Any) -> str:
    """ "19.1, 19.6, 19.0" """
    return ", ".join(f"{time:.1f}" for time in report["loop_times_s"]) or "-"


def mean_loop_time(report: Any) -> float:
    """NaN without a full circle [s]."""
    times = report["loop_times_s"]
    return mean(times) if times else math.nan


def spread(samples: Sequence[float]) -> Dict[str, Any]:
    """p50, p95, p99 and max by nearest rank, as reports have them; None without samples."""
    ordered = sorted(samples)

    def rank(share: float) -> Any:
        return ordered[max(1, math.ceil(share * len(ordered))) - 1] if ordered else None

    return {"p50": rank(0.5), "p95": rank(0.95), "p99": rank(0.99), "max": ordered[-1] if ordered else None}


def number(value: float) -> Any:
    """For JSON: None where there is none."""
    return value if math.isfinite(value) else None


def numbers(values: Sequence[float]) -> List[Any]:
    return [number(value) for value in values]
