"""The single object's circle with every projection, and the whole problem (15) on the states of such a run.

No table of the paper, but what its section VII-A says of (15).
"""

from __future__ import annotations

import dataclasses
import math
import pathlib
from dataclasses import dataclass, field
from typing import Any, Callable, Dict, List, Sequence, Tuple

from ..groups import Group
from ..reproduction import Reproduction, tell_table
from ..runs import RunResult
from ..scenario import read_scenario
from ..statistics import quantile
from ..summary import summarise, to_json
from ..tables import figure, mean_loop_time, number, numbers
from ..text_table import shown
from .gap import Planner, ask


@dataclass(frozen=True)
class Variant:
    name: str
    label: str
    overrides: List[str] = field(default_factory=list)  # where the projection has no scenario of its own


VARIANTS = (
    Variant("miqp", "C3, exact MIQP"),
    Variant("lcp", "C3, LCP", ["planner.c3.projection=lcp"]),
    Variant("admm", "C3, ADMM", ["planner.c3.projection=admm"]),
    Variant("convex", "C3, convex", ["planner.c3.projection=convex", "planner.model.contact_model=anitescu"]),
    Variant("plus", "C3+", ["planner.c3.projection=plus"]),
)
SCENARIOS = ("circle_slow", "circle_fast")
QUESTIONS = 40
Answers = List[Tuple[str, List[float], List[float]]]  # label, costs, times of the solves [s]


def comparison(reproduction: Reproduction) -> None:
    seeds = reproduction.settings.seeds
    results: Dict[str, Any] = {"what": "comparison", "seeds": seeds,
                               "paper": "VII-A: C3 at 73 Hz succeeds; (15) at about 5 Hz fails"}
    closed = [["", "passed", "circles", "s a circle", "in 2 cm [%]", "in 1 cm [%]", "rms [mm]", "max [mm]", "solve p50 [ms]",
               "p99 [ms]"]]
    for scenario in SCENARIOS:
        closed += _closed_loop(reproduction, scenario, results)
    opened = _open_loop(reproduction, results)
    tell_table(f"The circle with every projection, lockstep, seeds {seeds}, medians over the seeds", closed)
    tell_table("\nThe same question to all: the cost of (15) when the planning system is simulated with each one's inputs", opened)
    reproduction.finish(results)


def _group(reproduction: Reproduction, scenario: str, variant: Variant) -> Group:
    """The scenario with settings of the projection's own, if there is one, else that of all."""
    folder = pathlib.Path(read_scenario(reproduction.settings.program, scenario).file).parent
    own = f"{scenario}_{variant.name}"
    has_own = (folder / f"{own}.yaml").is_file()
    return Group(f"{scenario}-{variant.name}", own if has_own else scenario, overrides=[] if has_own else variant.overrides,
                 in_process=True)


def _closed_loop(reproduction: Reproduction, scenario: str, results: Dict[str, Any]) -> List[List[str]]:
    groups = [dataclasses.replace(_group(reproduction, scenario, variant), seeds=reproduction.settings.seeds)
              for variant in VARIANTS]
    rows = [[f"{scenario}, closed loop"]]
    of_scenario = results[scenario] = {}
    for variant, runs in zip(VARIANTS, reproduction.groups(groups)):
        summary = to_json(summarise(runs), runs)

        def value(path: str, factor: float, runs: Sequence[RunResult] = runs) -> str:
            return shown(factor * _median(runs, lambda report: figure(report, path)), 3)

        circle_s = _median(runs, mean_loop_time)
        rows.append([variant.label, f"{summary['success']['successes']} of {summary['success']['count']}",
                     value("loops_completed", 1), shown(circle_s, 3), value("objects.0.in_band_2cm", 100),
                     value("objects.0.in_band_1cm", 100), value("objects.0.rms_error_m", 1e3), value("objects.0.max_error_m", 1e3),
                     value("planner.solve_time_s.p50", 1e3), value("planner.solve_time_s.p99", 1e3)])
        spec = runs[0].spec
        of_scenario[variant.name] = {**summary, "seconds_a_circle": number(circle_s), "scenario": spec.scenario,
                                     "overrides": spec.overrides}
    return rows


def _median(runs: Sequence[RunResult], figure_of: Callable[[Any], float]) -> float:
    """Of one figure of their reports; NaN where none gives it."""
    values = sorted(value for value in (figure_of(run.report) for run in runs) if math.isfinite(value))
    return quantile(values, 0.5) if values else math.nan


def _open_loop(reproduction: Reproduction, results: Dict[str, Any]) -> List[List[str]]:
    scenario, limit = SCENARIOS[0], reproduction.settings.miqp_limit
    first = dataclasses.replace(_group(reproduction, scenario, VARIANTS[0]), name="recorded", logs=True)
    recorded = reproduction.runs([first])[0]
    program = reproduction.settings.program
    rate = float(read_scenario(program, first.scenario, first.overrides).values["planner"]["rate_hz"])
    period_s = 1.0 / rate  # what a planner has for one answer
    planners = []
    for variant in VARIANTS:
        group = _group(reproduction, scenario, variant)
        planners.append(Planner(variant.name, variant.label, scenario=group.scenario, overrides=group.overrides))
    assert recorded.report is not None
    found = ask(reproduction, "gap", str(recorded.folder / "run.mcap"),
                [f"--states={QUESTIONS}", f"--limit={limit:g}", "--relative-gap=1e-4"], recorded.report["log_hash"], scenario,
                planners)
    told = found.told
    states = told["states"]
    answers: Answers = [(planner.name, found.planners[planner.key].cost, found.planners[planner.key].solve_time_s)
                        for planner in planners]
    # the time of C3's answer, one of those from which the search starts, is its own, too
    costs = [math.nan if state["optimum_simulated"] is None else state["optimum_simulated"] for state in states]
    answers.append((f"(15), exact search, {limit:g} s", costs,
                    [state["solve_time_s"] + state["search_time_s"] for state in states]))

    best = [min((cost for cost in of_state if math.isfinite(cost)), default=math.inf)
            for of_state in zip(*(costs for _, costs, _ in answers))]
    rows = [["", "answers", "cost above best, p50 [%]", "p95 [%]", "time, p50 [ms]", "p95 [ms]",
             f"in a period of {1e3 * period_s:g} ms [%]"], [f"{len(states)} states of {first.scenario}, open loop"]]
    told_of = results["open_loop"] = {}
    for label, costs, times in answers:
        above = sorted(cost / least - 1.0 for cost, least in zip(costs, best) if math.isfinite(cost))
        ordered = sorted(times)
        fast = sum(time <= period_s for time in times)
        rows.append([label, f"{len(above)} of {len(states)}",
                     *(shown(100.0 * quantile(above, share), 3) if above else "-" for share in (0.5, 0.95)),
                     *(shown(1e3 * quantile(ordered, share), 3) for share in (0.5, 0.95)),
                     shown(100.0 * fast / len(times), 3)])
        told_of[label] = {"costs": numbers(costs), "times_s": times}
    told_of["proven"], told_of["states"] = told["proven"], len(states)
    rows.append([f"(15) proven to 1e-4: {told['proven']} of {len(states)}"])
    return rows
