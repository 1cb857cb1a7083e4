"""What many runs of one scenario amount to."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Dict, List, Sequence, Tuple

NORMAL_95 = 1.959963984540054  # quantile 0.975 of the normal distribution

# what a seed is called or how long it was recorded says nothing of how well it went; trials are runs themselves
NO_FIGURES = ("criteria", "seed", "trials")
# a longer time until something, a larger error, more events are worse, but not these
HIGHER_IS_BETTER = ("in_band", "success_rate", "loops_completed", "rate_hz", "real_time_factor", "turns", "cameras_used")


@dataclass(frozen=True)
class Proportion:
    """A share and the interval that holds the true one with 95 % confidence."""

    successes: int
    count: int
    share: float
    low: float
    high: float


def wilson(successes: int, count: int) -> Proportion:
    """Wilson's score interval, which also says something of 20 successes in 20. count: at least 1"""
    n, z2 = float(count), NORMAL_95 * NORMAL_95
    p = successes / n
    centre = (p + z2 / (2.0 * n)) / (1.0 + z2 / n)
    half = NORMAL_95 / (1.0 + z2 / n) * math.sqrt(p * (1.0 - p) / n + z2 / (4.0 * n * n))
    # rounding must not exclude what happened
    return Proportion(successes, count, p, min(p, max(0.0, centre - half)), max(p, min(1.0, centre + half)))


@dataclass(frozen=True)
class Distribution:
    """One figure over the runs that give it."""

    count: int
    mean: float
    p05: float
    median: float
    p95: float
    worst: float
    worst_index: int  # into the values


def distribution(values: Sequence[float], higher_is_better: bool) -> Distribution:
    """values: at least one, all finite"""
    worst = min(values) if higher_is_better else max(values)
    ordered = sorted(values)
    return Distribution(len(values), mean(values), quantile(ordered, 0.05), quantile(ordered, 0.5), quantile(ordered, 0.95),
                        worst, list(values).index(worst))


def mean(values: Sequence[float]) -> float:
    """Summed one after the other: newer Pythons' sum() rounds otherwise, and the same runs must give the same bits."""
    total = 0.0
    for value in values:
        total += value
    return total / len(values)


def quantile(ordered: Sequence[float], share: float) -> float:
    """Linear between the two samples around it (R's type 7). ordered: at least one"""
    place = share * (len(ordered) - 1)
    below = int(place)
    above = min(below + 1, len(ordered) - 1)
    return ordered[below] + (place - below) * (ordered[above] - ordered[below])


def figures(report: Any) -> Dict[str, float]:
    """Every number of a report by its path ("objects.0.rms_error_m"), in the report's order.

    Of a list of numbers its median and worst, of the reflexes how many. The criteria are not among them.
    """
    return dict(_collect("", report))


def _collect(path: str, value: Any) -> List[Tuple[str, float]]:
    if is_number(value):
        return [(path, float(value))]
    found: List[Tuple[str, float]] = []
    if isinstance(value, dict):
        for name, member in value.items():
            if name == "reflexes" and isinstance(member, list):
                found.append((path + name, float(len(member))))
            elif name not in NO_FIGURES:
                found += _collect(path + name + _dot(member), member)
    elif isinstance(value, list) and not all(is_number(item) for item in value):
        for index, item in enumerate(value):
            found += _collect(f"{path}{index}{_dot(item)}", item)
    elif isinstance(value, list) and value:
        of_list = distribution([float(item) for item in value], higher_is_better(path))
        found += [(path + "median", of_list.median), (path + "worst", of_list.worst)]
    return found


def _dot(value: Any) -> str:
    return "." if isinstance(value, (dict, list)) else ""


def is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def higher_is_better(figure: str) -> bool:
    """Whether more of a figure of a report is better."""
    return any(part in figure for part in HIGHER_IS_BETTER)
