"""`c3rt tune` as a person meets it, on a numerical example. Run by pytest; C3RT_PROGRAM names c3rt."""
import json
import os
import pathlib
import signal
import subprocess
import sys
import time

import pytest

pytest.importorskip("cmaes", reason="the package cmaes could not be had")

PROGRAM = os.environ["C3RT_PROGRAM"]
NUMBERS = ["--log", "c3.rho=0.01..10", "--linear", "c3.rho_scale=1.2..4", "--minimise", "accumulated_cost"]
SHORT = ["--duration", "1", "--population", "4", "--generations", "2", "--seeds", "101", "--test-seeds", "1"]
NO_FINAL = ["--finalists", "1"]


@pytest.fixture(autouse=True)
def this_python(monkeypatch):
    monkeypatch.setenv("C3RT_PYTHON", sys.executable)


def c3rt(*words, status=0):
    ran = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True, timeout=100)
    assert ran.returncode == status, ran.stdout + ran.stderr
    return ran.stdout + ran.stderr


def tune(out, *words, status=0):
    return c3rt("tune", "cart_pole", *NUMBERS, *SHORT, "--out", out, *(words or NO_FINAL), status=status)


def test_what_is_found_is_no_worse_and_is_a_scenario_that_gives_what_was_said(tmp_path):
    said = tune(tmp_path / "tune")
    told = json.loads((tmp_path / "tune" / "tune.json").read_text())
    costs = [candidate["accumulated_cost"] for generation in told["generations"] for candidate in generation]
    assert len(costs) == 8 and len(set(costs)) == 8
    assert told["best"]["accumulated_cost"] == min([told["start"]["accumulated_cost"], *costs])
    assert told["test"]["found"]["accumulated_cost"] <= told["test"]["start"]["accumulated_cost"]
    assert "no worse than the start" in said and all(value in said for value in told["best_values"])
    # criteria of a run this short are missed
    c3rt("run", tmp_path / "tune" / "cart_pole_tuned.yaml", "--set", "control.duration_s=1", "--out", tmp_path / "again", status=1)
    again = json.loads((tmp_path / "again" / "report.json").read_text())
    assert again["accumulated_cost"] == told["test"]["found"]["accumulated_cost"]
    # the same call keeps what is there
    before = (tmp_path / "tune" / "tune.json").read_bytes()
    marks = {file: file.stat().st_mtime_ns for file in (tmp_path / "tune").glob("*/report.json")}
    tune(tmp_path / "tune")
    assert (tmp_path / "tune" / "tune.json").read_bytes() == before
    assert marks == {file: file.stat().st_mtime_ns for file in (tmp_path / "tune").glob("*/report.json")}


def test_of_the_best_candidates_the_one_is_found_that_is_best_on_seeds_that_the_search_did_not_use(tmp_path):
    said = tune(tmp_path / "tune", "--finalists", "3", "--final-seeds", "201..203")
    told = json.loads((tmp_path / "tune" / "tune.json").read_text())
    all_candidates = [told["start"], *(candidate for generation in told["generations"] for candidate in generation)]
    best = sorted(all_candidates, key=lambda one: (one["failed"], one["shortfall"], one["accumulated_cost"]))[:3]
    finals = told["finals"]
    assert [final["values"] for final in finals] == [one.get("values", final["values"]) for one, final in zip(best, finals)]
    found = min(finals, key=lambda one: (one["failed"], one["shortfall"], one["accumulated_cost"]))
    assert told["best_values"] == found["values"]
    # a finalist's cost is that of its runs
    place = finals.index(found) + 1
    costs = [json.loads((tmp_path / "tune" / f"final-{place:02}-seed-{seed:04}" / "report.json").read_text())["accumulated_cost"]
             for seed in (201, 202, 203)]
    assert found["accumulated_cost"] == pytest.approx(sum(costs) / 3)
    assert "finalists, on seeds 101 and on final seeds 201..203" in said


def test_a_search_may_be_shorter_than_what_it_is_for(tmp_path):
    c3rt("tune", "cart_pole", *NUMBERS, *SHORT[2:], *NO_FINAL, "--set", "control.duration_s=1", "--search-set", "control.duration_s=0.2",
         "--out", tmp_path / "tune")
    told = json.loads((tmp_path / "tune" / "tune.json").read_text())
    assert told["start"]["accumulated_cost"] < told["test"]["start"]["accumulated_cost"]
    solves = {name: json.loads((tmp_path / "tune" / name / "report.json").read_text())["solves"]
              for name in ("start-01-seed-0101", "g001-c01-seed-0101", "test-01-seed-0001")}
    assert list(solves.values()) == [20, 20, 100]


def test_what_was_interrupted_goes_on_to_the_same_end(tmp_path):
    tune(tmp_path / "whole")
    process = subprocess.Popen([PROGRAM, "tune", "cart_pole", *NUMBERS, *SHORT, *NO_FINAL, "--out", str(tmp_path / "cut")],
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    for _ in range(1000):
        if list((tmp_path / "cut").glob("g001-*/report.json")):
            break
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 1 and "the same command goes on from there" in err, out + err
    tune(tmp_path / "cut")
    assert (tmp_path / "cut" / "tune.json").read_bytes() == (tmp_path / "whole" / "tune.json").read_bytes()


@pytest.mark.parametrize("words, says", [
    (["tune", "cart_pole", "--log", "c3.rho=0.01..10", "--minimise", "x"], "two numbers"),
    (["tune", "cart_pole", *NUMBERS[:4]], "--minimise FIGURE or --maximise FIGURE"),
    (["tune", "cart_pole", *NUMBERS, "--seeds", "1..3", "--test-seeds", "3"], "got 3 in both"),
    (["tune", "cart_pole", *NUMBERS, "--seeds", "1..3", "--final-seeds", "3,4", "--test-seeds", "5"], "got 3 in both"),
    (["tune", "cart_pole", *NUMBERS, "--final-seeds", "7..9"], "--test-seeds: expected seeds that are not among --final-seeds"),
    (["tune", "cart_pole", *NUMBERS[:4], "--minimise", "costs", *SHORT], "expected a figure of report.json, got costs"),
    (["tune", "cart_pole", *NUMBERS, "--log", "c3.rho=0.01..10"], "named twice"),
])
def test_a_mistake_is_named(tmp_path, words, says):
    assert says in c3rt(*words, "--out", tmp_path / "tune", status=2)
