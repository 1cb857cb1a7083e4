"""How good one candidate is."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Dict, List, Sequence

from .runs import RunResult
from .statistics import figures, is_number
from .status import PROCESS_FAILED

LEAST = 0.01  # of a criterion that is missed by a hair


@dataclass(frozen=True, order=True)
class Score:
    """Compared in this order: less is better."""

    failed: int = 0  # runs whose process failed
    shortfall: float = 0.0  # by how much of themselves criteria were missed, summed over the runs
    figure: float = math.inf  # mean over the runs; negative where more is better


def score(results: Sequence[RunResult], figure: str, more_is_better: bool) -> Score:
    """Of one candidate's results, at least one.

    figure: its path in report.json ("loop_times_s.median"), as figures() has it; of a run that does not give it, it is
    infinite.
    """
    failed, missed, mean = 0, 0.0, 0.0
    for result in results:
        if result.status == PROCESS_FAILED or result.report is None:
            failed += 1
            continue
        for criterion in result.report.get("criteria", []):
            missed += shortfall(criterion)
        value = figures(result.report).get(figure)
        mean += (math.inf if value is None else -value if more_is_better else value) / len(results)
    return Score(failed, missed, mean)


def shortfall(criterion: Dict[str, Any]) -> float:
    """In [0, 1]: 0 where it is met, 1 where there is no value at all."""
    if criterion.get("met", False):
        return 0.0
    got, wanted = criterion.get("value"), criterion.get("limit")
    if not is_number(got) or not is_number(wanted):
        return 1.0
    largest = max(abs(got), abs(wanted))
    return min(max(abs(got - wanted) / largest, LEAST), 1.0) if largest > 0.0 else LEAST


def ranks(scores: Sequence[Score]) -> List[float]:
    """The place of each among all, from 0; equals share theirs. What CMA-ES needs to know."""
    return [float(sum(other < one for other in scores)) for one in scores]


def text(score: Score, figure: str, more_is_better: bool) -> str:
    """As "all criteria met, loop_times_s.median 9.7", "criteria missed by 1.3, …", "2 runs failed"."""
    if score.failed > 0:
        return f"{score.failed} runs failed"
    criteria = f"criteria missed by {score.shortfall:.3g}" if score.shortfall > 0.0 else "all criteria met"
    value = -score.figure if more_is_better else score.figure
    return f"{criteria}, {figure} {f'{value:.4g}' if math.isfinite(value) else 'not reached'}"
