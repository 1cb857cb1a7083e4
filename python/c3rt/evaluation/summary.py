"""The one table of a campaign."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Dict, List, Optional, Sequence

from .runs import RunResult, replay_command
from .statistics import Distribution, Proportion, distribution, figures, higher_is_better, is_number, wilson
from .status import CRITERION_FAILED, DONE, PROCESS_FAILED
from .text_table import shown


@dataclass
class _Sample:
    """Values of one figure over the runs, and whose each is."""

    values: List[float] = field(default_factory=list)
    seeds: List[int] = field(default_factory=list)

    def add(self, value: float, seed: int) -> None:
        self.values.append(value)
        self.seeds.append(seed)


@dataclass(frozen=True)
class FigureSummary:
    name: str  # its path in report.json
    values: Distribution
    worst_seed: int


@dataclass(frozen=True)
class CriterionSummary:
    """One limit of the scenario over all runs."""

    name: str
    limit: float
    met: Proportion
    values: Optional[FigureSummary]  # of the runs that gave one


@dataclass(frozen=True)
class Summary:
    missed: int  # a criterion
    failed: int  # a process
    success: Proportion  # of all runs, those whose process failed included
    criteria: List[CriterionSummary]
    figures: List[FigureSummary]
    worst: int  # index of the run that is worth a look


def summarise(results: Sequence[RunResult]) -> Summary:
    """results: at least one"""
    count = {status: sum(result.status == status for result in results) for status in (DONE, CRITERION_FAILED, PROCESS_FAILED)}
    worst = 0
    for index in range(1, len(results)):
        if _is_worse(results[index], results[worst]):
            worst = index
    reported = [result for result in results if result.report is not None]
    return Summary(count[CRITERION_FAILED], count[PROCESS_FAILED], wilson(count[DONE], len(results)),
                   _summarise_criteria(reported), _summarise_figures(reported), worst)


def rows(summary: Summary) -> List[List[str]]:
    """A head line, then criteria, then figures."""
    table = [["", "met", "runs", "p5", "median", "p95", "worst", "of seed"]]
    for criterion in summary.criteria:
        table.append([f"criterion {criterion.name} (limit {criterion.limit:g})",
                      f"{criterion.met.successes} of {criterion.met.count}", *_cells(criterion.values)])
    for figure in summary.figures:
        table.append([figure.name, "", *_cells(figure)])
    return table


def verdict(summary: Summary) -> str:
    """As "18 of 20 passed (90 %, 95 % confidence: 70 to 97 %), 1 missed a criterion, 1 failed"."""
    p = summary.success
    text = (f"{p.successes} of {p.count} passed ({100 * p.share:.0f} %, 95 % confidence: "
            f"{100 * p.low:.0f} to {100 * p.high:.0f} %)")
    if summary.missed > 0:
        text += f", {summary.missed} missed a criterion"
    if summary.failed > 0:
        text += f", {summary.failed} failed"
    return text


def to_json(summary: Summary, results: Sequence[RunResult]) -> Dict[str, Any]:
    worst = results[summary.worst]
    return {
        "success": _share_json(summary.success),
        "missed_criteria": summary.missed,
        "failed": summary.failed,
        "worst": {"seed": worst.spec.seed, "command": replay_command(worst.spec)},
        "criteria": [_criterion_json(criterion) for criterion in summary.criteria],
        "figures": {figure.name: _figure_json(figure) for figure in summary.figures},
        "runs": [_run_json(result) for result in results],
    }


def _criteria(result: RunResult) -> List[Dict[str, Any]]:
    return [] if result.report is None else result.report.get("criteria", [])


def _unmet(result: RunResult) -> List[str]:
    return [criterion["name"] for criterion in _criteria(result) if not criterion.get("met", False)]


def _is_worse(a: RunResult, b: RunResult) -> bool:
    """A failed process is worse than any report; then what misses more criteria.

    Then the first criterion in the scenario's order that tells two runs apart.
    """
    if a.report is None or b.report is None:
        return a.report is None and b.report is not None
    if len(_unmet(a)) != len(_unmet(b)):
        return len(_unmet(a)) > len(_unmet(b))
    for ours, other in zip(_criteria(a), _criteria(b)):
        x, y = ours["value"], other["value"]
        if x != y and is_number(x) and is_number(y):
            return x < y if higher_is_better(ours["name"]) else x > y
    return False


def _summarise_criteria(reported: Sequence[RunResult]) -> List[CriterionSummary]:
    """The criteria are those of the scenario: the same of every run, in the same order."""
    summaries: List[CriterionSummary] = []
    for place, first in enumerate(_criteria(reported[0]) if reported else []):
        sample, successes = _Sample(), 0
        for result in reported:
            criterion = _criteria(result)[place]
            successes += bool(criterion.get("met", False))
            if is_number(criterion["value"]):
                sample.add(float(criterion["value"]), result.spec.seed)
        values = _of_sample(first["name"], sample) if sample.values else None
        summaries.append(CriterionSummary(first["name"], float(first["limit"]), wilson(successes, len(reported)), values))
    return summaries


def _summarise_figures(reported: Sequence[RunResult]) -> List[FigureSummary]:
    samples: Dict[str, _Sample] = {}
    for result in reported:
        for name, value in figures(result.report).items():
            samples.setdefault(name, _Sample()).add(value, result.spec.seed)
    return [_of_sample(name, sample) for name, sample in samples.items()]


def _of_sample(name: str, sample: _Sample) -> FigureSummary:
    values = distribution(sample.values, higher_is_better(name))
    return FigureSummary(name, values, sample.seeds[values.worst_index])


def _cells(figure: Optional[FigureSummary]) -> List[str]:
    if figure is None:
        return []
    of = figure.values
    return [str(of.count), *(shown(value) for value in (of.p05, of.median, of.p95, of.worst)), str(figure.worst_seed)]


def _share_json(p: Proportion) -> Dict[str, Any]:
    return {"successes": p.successes, "count": p.count, "share": p.share, "low": p.low, "high": p.high}


def _figure_json(figure: FigureSummary) -> Dict[str, Any]:
    of = figure.values
    return {"count": of.count, "mean": of.mean, "p05": of.p05, "median": of.median, "p95": of.p95, "worst": of.worst,
            "worst_seed": figure.worst_seed}


def _criterion_json(criterion: CriterionSummary) -> Dict[str, Any]:
    values = {} if criterion.values is None else {"values": _figure_json(criterion.values)}
    return {"name": criterion.name, "limit": criterion.limit, "met": _share_json(criterion.met), **values}


def _run_json(result: RunResult) -> Dict[str, Any]:
    return {
        "seed": result.spec.seed,
        "exit_status": result.status,
        "result": result.failure if result.report is None else result.report["result"],
        "criteria_missed": _unmet(result),
        "wall_s": result.wall_s,
        "folder": str(result.folder),
    }
