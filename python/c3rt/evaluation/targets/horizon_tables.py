"""Tables I and II: solve time and accumulated cost over the horizon N, by C3 and by the whole problem (15)."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Callable, Dict, List, Optional, Sequence

from ..reproduction import Example, Reproduction, tell_table
from ..runs import RunResult
from ..statistics import is_number, mean
from ..tables import number, read_columns
from ..text_table import shown
from .loops import loop_figures

HORIZONS = (10, 20, 30, 50)
GREYS = ("#202020", "#808080", "#b08000", "#9050a0")


@dataclass(frozen=True)
class Reference:
    """Numbers of others, as they print them, one for each horizon."""

    name: str
    values: Sequence[str]


@dataclass(frozen=True)
class Table:
    title: str
    scenario: str
    published: List[str]  # what the paper runs, on top of the scenario
    own: List[str]  # settings of our own, on top of these
    own_words: str
    has_limits: bool  # of the states, which a simulation may overshoot
    cost_unit: float  # of the table: 1e7
    times: Sequence[Reference]  # [ms]
    costs: Sequence[Reference]  # [cost_unit]


@dataclass
class Column:
    """A way to control, and what it gave at each horizon; nothing where it was not looked at."""

    key: str
    name: str
    short_name: str
    color: str
    overrides: List[str]
    options: List[str] = field(default_factory=list)
    figures: List[Dict[str, Any]] = field(default_factory=list)


# s = 5, ρ = 1, ρ_s = 1.01, cost over 2 s
TABLE_1 = Table(
    "Table I: finger gaiting, 2 s from [-8 0 3 0 4 0]", "finger_gaiting",
    ["control.duration_s=2", "c3.admm_iterations=5", "c3.rho=1", "c3.rho_scale=1.01", "c3.start=fresh",
     "start.x0=[-8, 0, 3, 0, 4, 0]", "start.spread_min=[0, 0, 0, 0, 0, 0]", "start.spread_max=[0, 0, 0, 0, 0, 0]"],
    # tried at N = 10: s 5, 10, 20; ρ 0.1, 1, 10; ρ_s 1.01, 1.2, 1.5, 2; the last solution shifted; then at all N: s 20 … 40
    # with ρ 1 … 10. More iterations help most; ρ 1 and ρ_s 1.05 … 1.1 are good at every N, others only at some
    ["c3.admm_iterations=20", "c3.rho_scale=1.05"], "own settings (s = 20, ρ_s = 1.05)", True, 1e7,
    # the paper; the authors' code on one core of a 2-core machine: its OSQP and Gurobi alone, and its MIQP at the one horizon
    # that Gurobi's free licence allows
    (Reference("paper: C3", ["25", "51", "67", "95"]),
     Reference("paper: MIQP", ["112", "294", "791", "2315"]),
     Reference("authors' code: C3, solvers alone", ["149", "276", "423", "771"]),
     Reference("authors' code: MIQP", ["171", "-", "-", "-"])),
    (Reference("paper: C3", ["4.979", "4.248", "4.101", "9.552"]),
     Reference("paper: MIQP", ["3.467", "3.454", "3.451", "3.452"]),
     Reference("independent exact C3", ["5.476", "5.197", "5.210", "5.210"]),
     Reference("independent MIQP", ["3.477", "3.457", "3.455", "3.461"])))

# s = 5, ρ = 0.02, ρ_s = 1.1, cost over 1.5 s
TABLE_2 = Table(
    "Table II: pivoting as published, 1.5 s without noise", "pivoting",
    ["control.duration_s=1.5", "model.equations=as_published", "plant.noise_sigma=0", "c3.admm_iterations=5", "c3.rho=0.02",
     "c3.rho_scale=1.1", "c3.start=carried_forces", "c3.start_reset_period_s=0.15"],
    # tried: the last solution shifted, carried over as published or forgotten; s 5, 10, 20; ρ 0.005, 0.01, 0.015, 0.02; ρ_s
    # 1.05, 1.1, 1.3. More iterations cost less and take longer; a smaller ρ and the shift take no time. With ρ 0.005, 2 to 6 %
    # less is possible up to N = 30, but the box does not reach its balance where friction is higher
    ["c3.start=shifted", "c3.rho=0.01"], "own settings (shifted start, ρ = 0.01)", False, 1e5,
    # the paper; the authors' code on one core of a 2-core machine: its OSQP and Gurobi alone
    (Reference("paper: C3", ["59", "111", "167", "334"]),
     Reference("paper: MIQP", ["132", "376", "1676", "> 300 s"]),
     Reference("authors' code: C3, solvers alone", ["230", "492", "899", "1627"])),
    (Reference("paper: C3", ["1.217", "0.954", "0.951", "0.968"]),
     Reference("paper: MIQP", ["1.214", "0.931", "0.865", "-"]),
     Reference("independent exact C3", ["1.233", "0.944", "0.906", "-"]),
     Reference("independent MIQP, gaps 2.7, 5.9, 11, 15 %", ["1.207", "0.954", "0.995", "1.245"])))


def table1(reproduction: Reproduction) -> None:
    _horizon_table(reproduction, TABLE_1)


def table2(reproduction: Reproduction) -> None:
    _horizon_table(reproduction, TABLE_2)


def _horizon_table(reproduction: Reproduction, table: Table) -> None:
    limit = reproduction.settings.miqp_limit
    own = table.published + table.own
    columns = [
        Column("c3", "C3, published settings", "C3", "#1f5fd0", table.published),
        Column("own", f"C3, {table.own_words}", "C3, own settings", "#2a8f4a", own),
        # C3's plan with our own settings is where the search starts
        Column("miqp", f"MIQP (15) from C3's plan, {limit:g} s limit", "MIQP", "#d04020", own, [f"--exact={limit:g}"]),
    ]
    horizons = HORIZONS[:1] if reproduction.settings.quick else HORIZONS
    runs = iter(reproduction.examples([
        Example(f"{column.key}-{N}", table.scenario, [*column.overrides, f"control.horizon={N}"], column.options)
        for column in columns for N in horizons]))
    for column in columns:
        column.figures = [_figures(next(runs)) if N in horizons else {} for N in HORIZONS]

    cost_label = f"accumulated cost [10^{math.log10(table.cost_unit):.0f}]"
    rows = [["horizon N", *(str(N) for N in HORIZONS)], ["solve time [ms], median of the calls"]]
    rows += [[f"  {reference.name}", *reference.values] for reference in table.times]
    rows += [_row(f"here: {column.name}", column, lambda of: _shown(of["solve_time_s"]["p50"], 1e3, 3)) for column in columns]
    rows.append([cost_label])
    rows += [[f"  {reference.name}", *reference.values] for reference in table.costs]
    rows += [_row(f"here: {column.name}", column, lambda of: _shown(of["accumulated_cost"], 1.0 / table.cost_unit))
             for column in columns]
    if table.has_limits:
        rows.append(["largest overshoot of the limits between the control steps [m]"])
        rows += [_row(f"here: {column.name}", column, lambda of: _shown(of["overshoot"], 1.0, 2)) for column in columns]
    miqp = columns[-1]
    rows += [["what the MIQP's search here proved"],
             _row("calls proven within a gap of 1e-4", miqp, lambda of: f"{of['proven']}/{of['calls']}"),
             _row("gap, mean [%]", miqp, lambda of: _shown(of["gap_mean"], 100.0, 2)),
             _row("calls without a plan", miqp, lambda of: str(of["controller_failures"]))]
    tell_table(table.title, rows)

    results: Dict[str, Any] = {"what": reproduction.settings.what, "miqp_limit_s": limit}
    for column in columns:
        results[column.key] = {str(N): figures for N, figures in zip(HORIZONS, column.figures)}
    times = [_curve(column, lambda of: _times(of["solve_time_s"]["p50"], 1e3)) for column in columns]
    costs = [_curve(column, lambda of: _times(of["accumulated_cost"], 1.0 / table.cost_unit)) for column in columns]
    reproduction.finish(results, {"title": table.title, "panels": [
        {"y_label": "solve time [ms]", "y_scale": "log", "curves": times + _references(table.times)},
        {"x_label": "horizon N", "y_label": cost_label, "curves": costs + _references(table.costs)}]})


def _figures(run: RunResult) -> Dict[str, Any]:
    figures = loop_figures(run)
    if not any(option.startswith("--exact") for option in run.spec.options):
        return figures
    search = read_columns(run.folder / "decisions.csv", ["gap", "proven"])
    # of decisions without a plan there is no gap, nor a mean of all
    return {**figures, "proven": round(sum(search["proven"])), "gap_mean": number(mean(search["gap"])),
            "gap_max": number(max(search["gap"]))}


def _row(name: str, column: Column, value: Callable[[Dict[str, Any]], str]) -> List[str]:
    return [f"  {name}", *(value(figures) if figures else "-" for figures in column.figures)]


def _shown(value: Any, factor: float, digits: int = 4) -> str:
    return shown(factor * value, digits) if is_number(value) else "-"


def _times(value: Any, factor: float) -> Optional[float]:
    return factor * value if is_number(value) else None


def _curve(column: Column, value: Callable[[Dict[str, Any]], Optional[float]]) -> Dict[str, Any]:
    return {"name": f"here: {column.short_name}", "color": column.color, "x": list(HORIZONS), "marks": "dot",
            "y": [value(figures) if figures else None for figures in column.figures]}


def _references(references: Sequence[Reference]) -> List[Dict[str, Any]]:
    return [{"name": reference.name, "color": GREYS[index % len(GREYS)], "x": list(HORIZONS), "line": "dashed", "marks": "dot",
             "y": [_number_of(value) for value in reference.values]} for index, reference in enumerate(references)]


def _number_of(text: str) -> Optional[float]:
    try:
        return float(text)
    except ValueError:
        return None
