"""How far plans are above the proven optimum of the whole problem (15), by planner."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field
from typing import Any, Dict, List, Optional, Sequence

from ..files import write_text
from ..groups import Group
from ..reproduction import Reproduction, tell_table
from ..scenario import read_scenario
from ..statistics import quantile
from ..tables import numbers
from ..text_table import Rows, shown

STATES, QUICK_STATES = 40, 3
LEAST_SHOWN = 1e-3  # in the picture, whose axis is a logarithm [%]


@dataclass(frozen=True)
class Planner:
    """Who is asked: a scenario's planner."""

    key: str
    name: str
    color: str = ""
    scenario: str = ""  # empty: that of the states
    overrides: List[str] = field(default_factory=list)
    polish: int = 0  # QPs that polish each plan; the one before it that has none is the same without


@dataclass(frozen=True)
class Asked:
    """What a planner answered at each state."""

    above: List[float]  # the optimum, as a share; NaN where the plan has no cost
    meets: List[bool]  # the constraints
    cost: List[float]
    solve_time_s: List[float]


@dataclass(frozen=True)
class Gap:
    """What c3rt gap told."""

    told: Any  # gap.json
    planners: Dict[str, Asked]  # by their keys, the first the one whose states these are


BLACK, GREY, BLUE, RED = "#000000", "#7f7f7f", "#0072b2", "#d55e00"
GREEN, ORANGE, PINK, SKY = "#009e73", "#e69f00", "#cc79a7", "#56b4e9"
QPS, MORE_QPS = 40, 100
OF_EXAMPLES = (
    Planner("c3", "C3, exact projection", BLACK),
    Planner("polish", f"… polish: {QPS}", BLUE, polish=QPS),
    Planner("plus", "C3+", RED, overrides=["c3.projection=plus"]),
    Planner("plus_polish", f"… polish: {QPS}", ORANGE, overrides=["c3.projection=plus"], polish=QPS),
    Planner("admm", "C3, ADMM", GREEN, overrides=["c3.projection=admm"]),
    Planner("convex", "C3, convex", PINK, overrides=["c3.projection=convex"]),
    Planner("lcp", "C3, LCP", SKY, overrides=["c3.projection=lcp"]),
)
OF_THE_BALL = (
    Planner("c3", "C3, exact projection", BLACK),
    Planner("polish", f"… polish: {QPS}", BLUE, polish=QPS),
    Planner("polish_more", f"… polish: {MORE_QPS}", GREY, polish=MORE_QPS),
    Planner("plus", "C3+, own weights", RED, "circle_slow_plus"),
    Planner("plus_polish", f"… polish: {QPS}", ORANGE, "circle_slow_plus", polish=QPS),
    Planner("admm", "C3, ADMM", GREEN, overrides=["planner.c3.projection=admm"]),
    Planner("convex", "C3, convex, own weights", PINK, "circle_slow_convex"),
    Planner("lcp", "C3, LCP", SKY, overrides=["planner.c3.projection=lcp"]),
)


@dataclass(frozen=True)
class Problem:
    key: str
    title: str
    scenario: str
    overrides: List[str]  # of the loop that the states are of, and of all planners
    planners: Sequence[Planner]
    is_example: bool = True  # else a run is recorded


PROBLEMS = (
    # the settings of our own of Tables I and II
    Problem("gaiting", "finger gaiting, own settings, N 10", "finger_gaiting", ["c3.admm_iterations=20", "c3.rho_scale=1.05"],
            OF_EXAMPLES),
    Problem("pivoting", "pivoting, own settings, N 10", "pivoting", ["c3.rho=0.01"], OF_EXAMPLES),
    Problem("ball", "one ball, circle_slow, N 5", "circle_slow", [], OF_THE_BALL, is_example=False),
)


def gap(reproduction: Reproduction) -> None:
    results: Dict[str, Any] = {"what": "gap"}
    panels: List[Dict[str, Any]] = []
    for problem in PROBLEMS:
        found = _found(reproduction, problem)
        told, states = found.told, len(found.told["states"])
        results[problem.key] = {
            "scenario": problem.scenario, "overrides": problem.overrides, "states": states, "proven": told["proven"],
            "relative_gap": told["relative_gap"],
            "planners": {planner.key: _figures(found, problem.planners, index)
                         for index, planner in enumerate(problem.planners)}}
        panels.append({"title": problem.title, "x_label": "share of the plans [%]",
                       "y_label": "above the optimum [%]",
                       "y_scale": "log", "curves": [_curve(problem.planners, index, found.planners[planner.key])
                                                        for index, planner in enumerate(problem.planners)]})
        tell_table(f"{problem.title}: {states} states, {told['proven']} optima proven to {told['relative_gap']:g}; plans "
                   "simulated, above the optimum", [*_rows(problem, results[problem.key]), [""]])
    reproduction.finish(results, {"title": f"Plans above the optimum of (15), the best first; no more than {LEAST_SHOWN:g} % is drawn "
                                           "there", "panels": panels})


def ask(reproduction: Reproduction, name: str, what: str, words: Sequence[str], inputs: Any, scenario: str,
        planners: Sequence[Planner], overrides: Sequence[str] = ()) -> Gap:
    """`c3rt gap WHAT WORDS`, with all planners but the first, which is the one that WHAT is of, as --planner.

    what: an example's file or a recording. inputs: what else its answer depends on. scenario, overrides: of planners that have
    no scenario of their own.
    """
    files, texts = [], []
    for planner in planners[1:]:
        read = read_scenario(reproduction.settings.program, planner.scenario or scenario, [*overrides, *planner.overrides])
        file = reproduction.folder(name) / f"{planner.key}.yaml"
        write_text(file, read.text)
        if planner.polish:
            plain = file.rename(file.with_name(f"{planner.key}-without.yaml"))
            c3 = f"c3: {{polish: {planner.polish}}}"
            write_text(file, f"name: {planner.key}\ndescription: polished plans\nextends: {plain}\n"
                       + (f"{c3}\n" if read.is_example else f"planner: {{{c3}}}\n"))
        files.append(file)
        texts.append([read.text, planner.polish])
    folder = reproduction.call(name, ["gap", what, *words, *(f"--planner={file}" for file in files), "--out={folder}"],
                               {"inputs": inputs, "planners": texts}, "gap.json")
    told = json.loads((folder / "gap.json").read_text(encoding="utf-8"))
    answers = {planners[0].key: _asked(told["states"])}
    for planner, file in zip(planners[1:], files):
        answers[planner.key] = _asked([state["planners"][str(file)] for state in told["states"]])
    return Gap(told, answers)


def _found(reproduction: Reproduction, problem: Problem) -> Gap:
    settings = reproduction.settings
    words = [f"--states={QUICK_STATES if settings.quick else STATES}", f"--limit={settings.miqp_limit:g}"]
    if problem.is_example:
        words += [f"--set={override}" for override in problem.overrides]
        return ask(reproduction, problem.key, problem.scenario, words,
                   reproduction.scenario_inputs(problem.scenario, problem.overrides), problem.scenario, problem.planners,
                   problem.overrides)
    recorded = reproduction.runs([Group(f"{problem.key}-run", problem.scenario, overrides=problem.overrides, logs=True,
                                        in_process=True)])[0]
    assert recorded.report is not None
    return ask(reproduction, problem.key, str(recorded.folder / "run.mcap"), words, recorded.report["log_hash"],
               problem.scenario, problem.planners, problem.overrides)


def _asked(plans: Sequence[Any]) -> Asked:
    def figures(name: str) -> List[float]:
        return [math.nan if plan[name] is None else plan[name] for plan in plans]

    return Asked(figures("above"), [plan["meets_constraints"] for plan in plans], figures("cost"), figures("solve_time_s"))


def _figures(found: Gap, planners: Sequence[Planner], index: int) -> Dict[str, Any]:
    of = found.planners[planners[index].key]
    known = sorted(above for above in of.above if math.isfinite(above))
    shares = {name: quantile(known, share) if known else None for name, share in (("median", 0.5), ("p90", 0.9), ("worst", 1.0))}
    figures = {"plans": len(known), "meet_constraints": sum(of.meets), **shares,
               "solve_time_s": quantile(sorted(of.solve_time_s), 0.5)}
    if planners[index].polish:
        alone = found.planners[_without(planners, index).key].solve_time_s
        figures["polish_time_s"] = quantile(sorted(whole - part for whole, part in zip(of.solve_time_s, alone)), 0.5)
    return {**figures, "above": numbers(of.above)}


def _without(planners: Sequence[Planner], index: int) -> Planner:
    """The same planner without polish."""
    return [planner for planner in planners[:index] if not planner.polish][-1]


def _rows(problem: Problem, results: Dict[str, Any]) -> Rows:
    rows = [["", "median [%]", "90 % [%]", "worst [%]", "plans", "meet the limits", "solve, p50 [ms]", "of it polish [ms]"]]
    for planner in problem.planners:
        of = results["planners"][planner.key]
        rows.append([planner.name, *(_shown(of[name], 100.0) for name in ("median", "p90", "worst")),
                     f"{of['plans']} of {results['states']}", f"{of['meet_constraints']} of {results['states']}",
                     _shown(of["solve_time_s"], 1e3), _shown(of.get("polish_time_s"), 1e3)])
    return rows


def _shown(value: Optional[float], factor: float) -> str:
    # what is below is rounding
    return "-" if value is None else shown(round(factor * value, 4) + 0.0, 3)


def _curve(planners: Sequence[Planner], index: int, asked: Asked) -> Dict[str, Any]:
    """From the best plan to the worst."""
    known = sorted(max(100.0 * above, LEAST_SHOWN) for above in asked.above if math.isfinite(above))
    planner = planners[index]
    name = planner.name.replace("…", f"{_without(planners, index).name},") if planner.polish else planner.name
    return {"name": name, "color": planner.color, "y": known,
            "x": [100.0 * (index + 1) / len(asked.above) for index in range(len(known))]}
