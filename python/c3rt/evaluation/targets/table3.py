"""Table III: the projections on the cart-pole between soft walls."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Dict, List

from ..reproduction import Example, Reproduction, tell_table
from ..runs import RunResult
from ..statistics import mean
from ..tables import number, numbers, read_columns, spread
from ..text_table import shown
from .loops import loop_figures


@dataclass(frozen=True)
class Method:
    key: str
    name: str
    color: str
    # the paper's; the authors' code on one core of a 2-core machine, without its limit of 1 ms
    paper_time: str = "-"
    paper_cost: str = "-"
    authors_time: str = "-"
    authors_cost: str = "-"


METHODS = (
    Method("lcp", "LCP", "#1f5fd0", "14 ± 1.8", "22.09", "14.4 ± 4.6", "22.12"),
    Method("miqp", "MIQP, exact", "#d04020", "1000 ± 120", "24.98", "850 ± 230", "25.03"),
    # not the paper's cost: the authors' code leaves its nested ADMM after one turn
    Method("admm", "ADMM", "#c8a000", "530 ± 33", "35.74", "900 ± 230", "35.82"),
    Method("convex", "convex (24)", "#2a8f4a"),
    Method("plus", "C3+", "#9050a0"),
)


def table3(reproduction: Reproduction) -> None:
    rows = [["", "one projection [µs], mean ± std", "", "", "", "mean cost-to-go", "", ""],
            ["projection", "paper", "authors' code", "here", "median", "paper", "authors' code", "here"]]
    results: Dict[str, Any] = {"what": "table3"}
    curves: List[Dict[str, Any]] = []
    runs = reproduction.examples([Example(method.key, "cart_pole", [f"c3.projection={method.key}"], ["--trace"])
                                  for method in METHODS])
    for method, run in zip(METHODS, runs):
        of = results[method.key] = _figures(run)
        time = of["projection_s"]
        rows.append([method.name, method.paper_time, method.authors_time,
                     f"{shown(1e6 * time['mean'], 3)} ± {shown(1e6 * time['std'], 2)}", shown(1e6 * time["p50"], 3),
                     method.paper_cost, method.authors_cost,
                     "-" if of["mean_cost_to_go"] is None else shown(of["mean_cost_to_go"])])
        curves.append({"name": method.name, "color": method.color, "y": of["cost_to_go"],
                       "x": [index * of["period_s"] for index in range(len(of["cost_to_go"]))]})
    tell_table("Table III: cart-pole with soft walls, one core", rows)
    reproduction.finish(results, {"title": "Table III: cart-pole with soft walls", "panels": [
        {"x_label": "time [s]", "y_label": "cost-to-go of the plans", "y_scale": "log", "curves": curves}]})


def _figures(run: RunResult) -> Dict[str, Any]:
    decisions = read_columns(run.folder / "decisions.csv",
                             ["t_s", "cost_to_go", "projection_s", "projections_not_solved"])
    times = [time for time in decisions["projection_s"] if math.isfinite(time)]
    if len(decisions["t_s"]) < 2 or not times:
        raise RuntimeError(f"{run.folder}: too few decisions")
    middle = mean(times)
    figures = loop_figures(run)
    del figures["solve_time_s"]  # beside the stopwatch
    return {
        **figures, "calls": len(times),
        "projection_s": {"mean": number(middle), "std": number(math.sqrt(mean([(time - middle)**2 for time in times]))),
                         "p50": spread(times)["p50"]},
        "projections_not_solved": round(sum(decisions["projections_not_solved"])),
        "cost_to_go": numbers(decisions["cost_to_go"]), "period_s": decisions["t_s"][1],
    }
