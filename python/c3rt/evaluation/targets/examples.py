"""Figures 3, 5, 7 and 8: closed loops of the numerical examples."""

from __future__ import annotations

import json
import math
from typing import Any, Dict, List, Sequence, Tuple

from ..reproduction import Example, Reproduction, tell_table
from ..runs import RunResult
from ..scenario import read_scenario
from ..statistics import mean
from ..tables import Columns, numbers, read_columns
from ..text_table import shown, shortest
from .loops import loop_figures

BLACK, BLUE, RED, GREY, YELLOW = "#202020", "#1f5fd0", "#d04020", "#808080", "#c8a000"
FINGERS = (("finger_1", "finger 1", BLUE), ("finger_2", "finger 2", RED))
SHADES = (("normal_1_n", "finger 1 pushes", "#cfe0fa", 0.5, 1.0), ("normal_2_n", "finger 2 pushes", "#fad5cf", 0.0, 0.5))
PUSHES_N = 1e-3  # a normal force above this is contact
NORMALS = ["normal_1_n", "normal_2_n"]
Panel = Dict[str, Any]


def fig3(reproduction: Reproduction) -> None:
    """Finger gaiting with s = 10."""
    # the initial state of the published code
    run = reproduction.examples([Example("run", "finger_gaiting", [
        "c3.admm_iterations=10", "control.duration_s=3", "start.x0=[-8, 0, 3, 0, 4, 0]", "start.spread_min=[0, 0, 0, 0, 0, 0]",
        "start.spread_max=[0, 0, 0, 0, 0, 0]"])])[0]
    accelerations = ["acceleration_1_m_per_s2", "acceleration_2_m_per_s2"]
    table = read_columns(run.folder / "trajectory.csv", ["t_s", "object_m", "finger_1_m", "finger_2_m", *NORMALS, *accelerations])
    # object of the published code, run independently with exact projections
    published = ((0.25, "-6.70"), (0.5, "-5.03"), (0.75, "-3.97"), (1.0, "-3.52"), (1.5, "-2.41"), (2.0, "-1.62"), (3.0, "-1.10"))
    rows = [["t [s]", "object", "finger 1", "finger 2", "the authors' code: object"]]
    for time, place in published:
        step = round(time / table["t_s"][1])
        if step < len(table["t_s"]):
            rows.append([shown(time), *(f"{table[name][step]:.2f}" for name in ("object_m", "finger_1_m", "finger_2_m")), place])
    tell_table("Figure 3: finger gaiting with s = 10; heights [m]", rows)
    results = {**loop_figures(run), **{name: numbers(table[name]) for name in ("object_m", "finger_1_m", "finger_2_m")},
               **_normals(table)}
    values = _values(reproduction, run)
    limits = sorted({float(limit) for side in ("x_min", "x_max") for limit in values["constraints"][side] if "inf" not in limit})
    heights: Panel = {"y_label": "height [m]", "shades": _shades(table), "curves": [
        _curve(table, "object_m", "object", BLACK), *(_curve(table, f"{key}_m", name, color) for key, name, color in FINGERS),
        _level(table, float(values["goal"]["x_desired"][0]), "goal of the object", GREY),
        *(_level(table, limit, "" if index else "limits of the fingers", YELLOW) for index, limit in enumerate(limits))]}
    reproduction.finish(results, {"title": "Figure 3: finger gaiting with s = 10", "panels": [
        heights,
        {"y_label": "normal force [N]", "curves": [
            _curve(table, normal, name, color) for normal, (_, name, color) in zip(NORMALS, FINGERS)]},
        {"x_label": "time [s]", "y_label": "acceleration [m/s²]", "curves": [
            _curve(table, acceleration, name, color) for acceleration, (_, name, color) in zip(accelerations, FINGERS)]}]})


def fig5(reproduction: Reproduction) -> None:
    """Pivoting with process noise σ = 0.1 and 0.5."""
    sigmas = ("0.1", "0.5")
    runs = reproduction.examples([Example(sigma, "pivoting", [f"plant.noise_sigma={sigma}"]) for sigma in sigmas])
    rows = [["σ", "α at the end [rad]", "x [m]", "y [m]", "f1 [m]", "f2 [m]", "balanced"],
            ["goal", "0.785", "0", "1.414", "0.9", "0.9", ""]]
    results: Dict[str, Any] = {}
    panels: List[Panel] = []
    for sigma, run in zip(sigmas, runs):
        states = ["alpha_rad", "x_m", "y_m", "finger_1_m", "finger_2_m"]
        table = read_columns(run.folder / "trajectory.csv", ["t_s", *states, *NORMALS])
        of = results[sigma] = {**loop_figures(run), "alpha_rad": numbers(table["alpha_rad"]), **_normals(table)}
        rows.append([sigma, *(f"{table[name][-1]:.3f}" for name in states), "yes" if of["succeeded"] else "no"])
        goal = [float(value) for value in _values(reproduction, run)["goal"]["x_desired"]]
        panels += [
            {"title": f"σ = {sigma}", "y_label": "angle α [rad]", "shades": _shades(table), "curves": [
                _curve(table, "alpha_rad", "α", BLACK), _level(table, goal[4], "goal", GREY)]},
            {"title": f"σ = {sigma}", "y_label": "fingers along their faces [m]", "curves": [
                *(_curve(table, f"{key}_m", name, color) for key, name, color in FINGERS), _level(table, goal[6], "goal", GREY)]}]
    panels[-1]["x_label"] = "time [s]"
    tell_table("Figure 5: pivoting with process noise of σ × 1 ms per step, equations corrected", rows)
    reproduction.finish(results, {"title": "Figure 5: pivoting with process noise", "panels": panels})


STATE = (0.44, 0.1, 0.6, -0.2)  # the paper does not say which: the cart moves to the right, the tip 1 cm from the right wall
ITERATIONS = ((1, "#b0b0b0"), (3, RED), (10, BLUE))
WALLS = ("right_wall", "left_wall")


def fig7(reproduction: Reproduction) -> None:
    """What the iterations of Algorithm 1 do to a contact force that is about to begin."""
    run = reproduction.examples([Example("run", "cart_pole_hardware", [
        f"start.x0=[{', '.join(shortest(value) for value in STATE)}]", "control.duration_s=0.1"], ["--trace"])])[0]
    forces, gaps = [f"{wall}_n" for wall in WALLS], [f"gap_of_{wall}" for wall in WALLS]
    table = read_columns(run.folder / "iterates.csv", ["iteration", "stage", *forces, *gaps])
    values = _values(reproduction, run)
    step = float(values["control"]["planning_step_s"])
    results: Dict[str, Any] = {"what": "fig7", "state": list(STATE), "time_s": [], "iterations": {}}
    rows = [["ADMM iteration", "largest λ₁ [N]", "largest violation", "mean violation"]]
    force: Panel = {"y_label": "force of the right wall λ₁ [N]", "curves": []}
    violation: Panel = {"x_label": "time ahead [s]", "y_label": "violation max |min(λ, y)|", "curves": []}
    for iteration, color in ITERATIONS:
        of = [index for index, number_of in enumerate(table["iteration"]) if number_of == iteration]
        if not of:
            raise RuntimeError(f"{run.folder}: no iteration {iteration}")
        pushing = [table[forces[0]][index] for index in of]
        violated = [max(abs(min(table[lam][index], table[gap][index])) for lam, gap in zip(forces, gaps)) for index in of]
        times = results["time_s"] = [step * table["stage"][index] for index in of]
        results["iterations"][str(iteration)] = {"lambda_1_n": numbers(pushing), "violation": numbers(violated)}
        rows.append([str(iteration), shown(max(pushing)), shown(max(violated)), shown(mean(violated))])
        for panel, curve in ((force, pushing), (violation, violated)):
            panel["curves"].append({"name": f"iteration {iteration}", "color": color, "x": times, "y": curve, "marks": "dot"})
    position, angle, velocity, rate = (shortest(value) for value in STATE)
    tell_table(f"Figure 7: cart-pole at [{position} m, {angle} rad, {velocity} m/s, {rate} rad/s], walls at "
               f"{values['model']['wall_distance_m']} m", rows)
    reproduction.finish(results, {"title": "Figure 7: the iterations near a contact", "panels": [force, violation]})


def fig8(reproduction: Reproduction) -> None:
    """The cost-to-go that C3 and the whole problem (15) expect along a run of the nonlinear cart-pole, and the one that came."""
    limit = reproduction.settings.miqp_limit
    run = reproduction.examples([Example("run", "cart_pole_hardware")])[0]
    table = read_columns(run.folder / "decisions.csv", ["t_s", "cost_to_go", "actual_cost"])
    # of the same trial, whose states the exact search answers anew
    sets = [f"--set={override}" for override in reproduction.quick_overrides()]
    folder = reproduction.call("gap", ["gap", "cart_pole_hardware", f"--states={len(table['t_s'])}", f"--limit={limit:g}",
                                       "--relative-gap=1e-4", *sets, "--out={folder}"],
                               reproduction.scenario_inputs("cart_pole_hardware"), "gap.json")
    told = json.loads((folder / "gap.json").read_text(encoding="utf-8"))
    c3, came = table["cost_to_go"], table["actual_cost"]
    optimum = [math.nan if state["optimum_simulated"] is None else state["optimum_simulated"] for state in told["states"]]
    known = sum(math.isfinite(cost) for cost in came)
    # relative to costs near zero, the search's own gap would be all that is left
    excess = max([0.0, *(above / below - 1.0 for above, below in zip(c3, optimum) if below > 1.0)])
    rows = [["cost-to-go", "mean", "largest"]]
    for name, costs in (("C3's inputs, predicted by the LCS", c3), ("MIQP's inputs, predicted by the LCS", optimum),
                        ("what the plant did", came)):
        rows.append([name, shown(mean(costs[:known])), shown(max(costs[:known]))] if known else [name, "-", "-"])
    tell_table("Figure 8: cost-to-go (14) along a run of the nonlinear cart-pole",
               [*rows, [""], [f"MIQP: {told['proven']} of {len(c3)} calls proven within a gap of 1e-4; C3's cost is at most "
                              f"{100.0 * excess:.2g} % above where it is over 1"]])
    values = _values(reproduction, run)
    push = values["plant"]["disturbance"]
    begin = float(push["start_s"])
    shades = [{"name": "disturbance", "color": "#e4e4e4", "intervals": [[begin, begin + float(push["duration_s"])]]}]
    curves = [{"name": "actual", "color": BLACK, "x": table["t_s"], "y": came},
              {"name": "C3", "color": BLUE, "x": table["t_s"], "y": c3},
              {"name": "MIQP", "color": RED, "x": table["t_s"], "y": optimum, "line": "dashed"}]
    # a logarithm has no 0
    above_zero = [{**curve, "y": [cost if cost > 0.0 else None for cost in curve["y"]]} for curve in curves]
    reproduction.finish(
        {"c3": numbers(c3), "miqp": numbers(optimum), "miqp_proven": told["proven"], "actual": numbers(came),
         "period_s": float(values["control"]["period_s"])},
        {"title": "Figure 8: cost-to-go of the cart-pole experiment", "panels": [
            {"y_label": "cost-to-go", "curves": curves, "shades": shades},
            {"x_label": "time [s]", "y_label": "cost-to-go", "y_scale": "log", "curves": above_zero, "shades": shades}]})


def _values(reproduction: Reproduction, run: RunResult) -> Any:
    return read_scenario(reproduction.settings.program, run.spec.scenario, run.spec.overrides).values


def _normals(table: Columns) -> Dict[str, List[Any]]:
    """Of the steps; after the last one nothing acts."""
    return {name: numbers(table[name][:-1]) for name in NORMALS}


def _curve(table: Columns, column: str, name: str, color: str) -> Dict[str, Any]:
    return {"name": name, "color": color, "x": table["t_s"], "y": numbers(table[column])}


def _level(table: Columns, y: float, name: str, color: str) -> Dict[str, Any]:
    return {"name": name, "color": color, "x": [table["t_s"][0], table["t_s"][-1]], "y": [y, y], "line": "dashed"}


def _shades(table: Columns) -> List[Dict[str, Any]]:
    """When each finger pushes."""
    return [{"name": name, "color": color, "low": low, "high": high, "intervals": _intervals(table["t_s"], table[normal])}
            for normal, name, color, low, high in SHADES]


def _intervals(times: Sequence[float], force: Sequence[float]) -> List[Tuple[float, float]]:
    """In which it pushes: the force of each step acts until the next one."""
    found: List[Tuple[float, float]] = []
    for index in range(len(times) - 1):
        if not force[index] > PUSHES_N:
            continue
        if found and found[-1][1] == times[index]:
            found[-1] = (found[-1][0], times[index + 1])
        else:
            found.append((times[index], times[index + 1]))
    return found
