#!/usr/bin/env python3
"""`c3rt reproduce` as a person meets it, with real runs of a few simulated seconds. Needs nothing but Python 3.

    C3RT_PROGRAM=build/release/bin/c3rt reproduce_test.py
"""
import csv
import json
import math
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAM = os.environ["C3RT_PROGRAM"]
PYTHONS = [os.environ["C3RT_PYTHON"]] if "C3RT_PYTHON" in os.environ else ["python3", "/usr/bin/python3"]
PACKAGE = pathlib.Path(__file__).resolve().parents[2] / "python"


def can_import(python, module):
    try:
        return subprocess.run([python, "-c", f"import {module}"], capture_output=True).returncode == 0
    except OSError:
        return False


HAS_PICTURES = any(can_import(python, "matplotlib") for python in PYTHONS)


class Reproduce(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)

    def reproduce(self, status, *words, environment=None):
        """What it says on both streams."""
        ran = subprocess.run([PROGRAM, "reproduce", *words, "--out", str(self.folder)], stdout=subprocess.PIPE,
                             stderr=subprocess.STDOUT, text=True, env={**os.environ, **(environment or {})})
        self.assertEqual(ran.returncode, status, ran.stdout)
        self.assertNotIn("Traceback", ran.stdout)
        return ran.stdout

    def says(self, text, *parts):
        for part in parts:
            self.assertIn(part, text)

    def results(self, what):
        return json.loads((self.folder / f"{what}.json").read_text())

    def has_picture(self, what, said):
        file = self.folder / f"{what}.png"
        if HAS_PICTURES:
            self.assertEqual(file.read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
            self.says(said, str(file))
        else:
            self.says(said, f"{what}.png is missing")

    def table(self, file):
        with (self.folder / file).open(newline="") as stream:
            return [{name: float(value) if value else math.nan for name, value in row.items()} for row in csv.DictReader(stream)]

    def test_a_table_that_the_paper_does_not_have_is_a_usage_error_that_lists_those_of_the_package(self):
        known = subprocess.run([sys.executable, "-c", "from c3rt.evaluation.reproduce import TARGETS; print(*TARGETS)"],
                               stdout=subprocess.PIPE, text=True, env={**os.environ, "PYTHONPATH": str(PACKAGE)}, check=True)
        said = self.reproduce(2, "table9")
        self.says(said, ", ".join(known.stdout.split()))
        self.assertEqual(len(known.stdout.split()), 15)
        for words in ([], ["table1", "--miqp-limit", "-1"], ["comparison", "--quick", "--seeds", "5..1"]):
            self.reproduce(2, *words)

    def test_table_3_has_every_projection_beside_the_papers(self):
        said = self.reproduce(0, "table3", "--quick")
        self.says(said, "22.09", "24.98", "35.74")
        self.has_picture("table3", said)
        table = self.results("table3")
        for projection in ("lcp", "miqp", "admm", "convex", "plus"):
            with self.subTest(projection):
                row = table[projection]
                self.assertEqual(row["calls"], 30)  # 0.3 s at 100 Hz
                self.assertEqual((row["controller_failures"], row["projections_not_solved"]), (0, 0))
                self.assertGreater(row["projection_s"]["mean"], 0.0)
                self.assertEqual(len(row["cost_to_go"]), 30)
                # of the trial's mean, which the program took
                self.assertAlmostEqual(sum(row["cost_to_go"]) / 30, row["mean_cost_to_go"], delta=1e-9 * row["mean_cost_to_go"])
        self.says(self.reproduce(0, "table3", "--quick"), "table3-lcp: kept from an earlier run")

    def test_table_2_has_c3_and_the_whole_problem_and_what_its_search_proved(self):
        self.says(self.reproduce(0, "table2", "--quick", "--miqp-limit", "20"), "1.217", "calls proven within a gap of 1e-4")
        table = self.results("table2")
        for way in ("c3", "own", "miqp"):
            of = table[way]["10"]
            self.assertEqual((of["calls"], of["controller_failures"], of["plant_failed"]), (5, 0, False))
            self.assertEqual(table[way]["20"], {})
        # the optimum of each plan is no better in closed loop by more than a little, and no worse
        self.assertLess(abs(table["miqp"]["10"]["accumulated_cost"] / table["c3"]["10"]["accumulated_cost"] - 1.0), 0.2)
        self.assertEqual(table["miqp"]["10"]["proven"], 5)
        self.assertLess(table["miqp"]["10"]["gap_max"], 1.001e-4)

    def test_figure_3_and_5_draw_what_the_examples_did(self):
        self.has_picture("fig3", self.reproduce(0, "fig3", "--quick"))
        results, rows = self.results("fig3"), self.table("runs/fig3-run/trajectory.csv")
        self.assertEqual(results["object_m"], [row["object_m"] for row in rows])
        self.assertEqual(results["object_m"][0], -8.0)
        self.assertEqual(len(results["normal_1_n"]), len(rows) - 1)
        self.has_picture("fig5", self.reproduce(0, "fig5", "--quick"))
        noisy = self.results("fig5")
        self.assertEqual(len(noisy["0.5"]["alpha_rad"]), 301)
        self.assertNotEqual(noisy["0.1"]["alpha_rad"], noisy["0.5"]["alpha_rad"])

    def test_figure_7_violates_complementarity_less_and_less(self):
        self.has_picture("fig7", self.reproduce(0, "fig7"))
        iterations = self.results("fig7")["iterations"]
        self.assertLess(max(iterations["10"]["violation"]), 1e-2 * max(iterations["1"]["violation"]))
        self.assertEqual(len(iterations["10"]["lambda_1_n"]), 10)

    def test_figure_8_has_no_plan_below_the_proven_optimum(self):
        self.has_picture("fig8", self.reproduce(0, "fig8", "--quick"))
        costs = self.results("fig8")
        self.assertEqual(costs["miqp_proven"], 30)
        for c3, optimum in zip(costs["c3"], costs["miqp"]):
            self.assertLessEqual(optimum, c3 * (1.0 + 2e-4) + 1e-6)
        self.assertEqual([cost is None for cost in costs["actual"]], [False] * 21 + [True] * 9)
        self.says(self.reproduce(0, "fig8", "--quick"), "gap: kept from an earlier run")

    def test_gap_has_every_planner_above_what_is_proven_and_polish_nearer_to_it(self):
        said = self.reproduce(0, "gap", "--quick")
        self.has_picture("gap", said)
        self.says(said, "finger gaiting", "pivoting", "one ball", "of it polish")
        results = self.results("gap")
        for problem, count in (("gaiting", 7), ("pivoting", 7), ("ball", 8)):
            with self.subTest(problem):
                of = results[problem]
                self.assertEqual((of["states"], of["proven"]), (3, 3))
                planners = of["planners"]
                self.assertEqual(len(planners), count)
                for planner in planners.values():
                    for above in planner["above"]:
                        # what breaks the limits may cost less
                        if above is not None and planner["meet_constraints"] == 3:
                            self.assertGreaterEqual(above, -of["relative_gap"])
                self.assertLessEqual(planners["polish"]["median"], planners["c3"]["median"])
                self.assertNotIn("polish_time_s", planners["c3"])
        self.says(self.reproduce(0, "gap", "--quick"), "gaiting: kept from an earlier run", "ball: kept from an earlier run")

    def test_figure_11_runs_both_circles_and_its_tracks_agree_with_their_reports(self):
        self.has_picture("fig11", self.reproduce(0, "fig11", "--quick"))
        results = self.results("fig11")
        self.assertEqual(results["slow"]["paper"]["loop_time_s"], 30.0)
        self.assertEqual(results["fast"]["report"]["scenario"], "circle_fast")
        report = results["slow"]["report"]
        track = self.table("runs/fig11-slow-series/objects.csv")
        self.assertGreater(len(track), 100)
        self.assertLess(track[0]["t_s"], 0.02)
        # distance to the circle of 0.1 m about (0.55, 0)
        for row in track:
            row["far"] = abs(math.hypot(row["object_0_x_m"] - 0.55, row["object_0_y_m"]) - 0.1)
            self.assertAlmostEqual(row["object_0_error_m"], row["far"], delta=1e-9)
        self.assertAlmostEqual(max(row["far"] for row in track), report["objects"][0]["max_error_m"], delta=2e-6)
        for corner in self.table("runs/fig11-slow-series/path.csv"):
            self.assertAlmostEqual(math.hypot(corner["x_m"] - 0.55, corner["y_m"]), 0.1, delta=1e-6)
        arm = self.table("runs/fig11-slow-series/end_effector.csv")
        self.assertGreater(len(arm), 1000)
        # the report counts from a second after tracking began, which the approach is part of
        error = max(math.dist([row[f"{axis}_m"] for axis in "xyz"], [row[f"desired_{axis}_m"] for axis in "xyz"]) for row in arm)
        self.assertLessEqual(error, report["end_effector"]["tracking_error_m"]["max"] + 1e-8)
        self.assertGreater(error, 1e-4)

    def test_figure_18_has_the_errors_that_the_reports_judge(self):
        self.has_picture("fig18", self.reproduce(0, "fig18", "--quick"))
        report = self.results("fig18")["line"]["report"]
        track = [row for row in self.table("runs/fig18-line-series/objects.csv") if row["t_s"] >= 1.0]
        for column, figures in (("object_0_error_m", report["judged"]),
                                ("object_0_to_held_points_m", report["path"]["to_held_points"])):
            self.assertAlmostEqual(max(row[column] for row in track), figures["max_error_m"], delta=2e-6)
        # x_d(t) is what the task is judged by
        self.assertEqual([row["object_0_error_m"] for row in track], [row["object_0_to_interpolated_path_m"] for row in track])

    def test_the_comparison_asks_every_projection_the_same_and_none_is_below_the_optimum(self):
        said = self.reproduce(0, "comparison", "--quick", "--seeds", "1", "--miqp-limit", "0.2")
        self.says(said, "C3, exact MIQP", "40 states of circle_slow, open loop", "(15), exact search, 0.2 s")
        results = self.results("comparison")
        self.assertEqual(results["circle_slow"]["plus"]["scenario"], "circle_slow_plus")
        self.assertEqual(results["circle_slow"]["lcp"]["overrides"], ["planner.c3.projection=lcp"])
        # the command that was asked for it shows the same
        self.says((self.folder / "runs/comparison-gap/call.log").read_text(), "above the optimum", "by convex", "by plus")
        opened = results["open_loop"]
        optimum = opened["(15), exact search, 0.2 s"]["costs"]
        for label in ("C3, exact MIQP", "C3, ADMM", "C3, convex", "C3+"):
            costs = opened[label]["costs"]
            self.assertEqual(len(costs), 40)
            answered = [(cost, best) for cost, best in zip(costs, optimum) if cost is not None and best is not None]
            self.assertGreaterEqual(len(answered), 38, label)
            # C3+ copies gaps, too, which are no inputs: taken for some they cost 1e7 times as much
            self.assertLess(sorted(cost / best for cost, best in answered)[len(answered) // 2], 20.0, label)

    def test_push_anything_has_each_objects_share_of_seeds_and_what_was_left(self):
        self.says(self.reproduce(0, "push_anything", "--quick", "--seeds", "1..2"), "box", "26.9")
        cases = self.results("push_anything")["cases"]
        self.assertEqual(len(cases), 2)
        for case in cases:
            self.assertEqual(case["runs"], 2)
            self.assertEqual(len(case["goal_times_s"]), case["reached"])
            self.assertEqual(len(case["end_position_errors_mm"]), 2)

    def test_an_interrupted_table_ends_at_once_with_its_runs_kept_and_the_next_call_uses_them(self):
        # the whole problem with N = 20 alone takes far longer
        words = [PROGRAM, "reproduce", "table1", "--miqp-limit", "60", "--out", str(self.folder)]
        first = self.folder / "runs/table1-c3-10/run.json"
        made = []
        for last in ("own-50", "miqp-10"):
            process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            deadline = time.monotonic() + 60
            while not (self.folder / f"runs/table1-{last}/run.json").exists():
                self.assertLess(time.monotonic(), deadline, f"{last} has not ended")
                time.sleep(0.05)
            process.send_signal(signal.SIGINT)
            said, _ = process.communicate(timeout=30)
            self.assertEqual(process.returncode, 1, said)
            self.says(said, "interrupted", "goes on from there")
            self.assertFalse((self.folder / "table1.json").exists())
            made.append(first.stat().st_mtime_ns)
        self.assertEqual(made[0], made[1])

    def test_an_interrupted_search_over_states_ends_at_once(self):
        process = subprocess.Popen([PROGRAM, "reproduce", "fig8", "--miqp-limit", "60", "--out", str(self.folder)],
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        deadline = time.monotonic() + 60
        while not (self.folder / "runs/fig8-gap/call.log").exists():
            self.assertLess(time.monotonic(), deadline, "the search has not begun")
            time.sleep(0.02)
        process.send_signal(signal.SIGINT)
        said, _ = process.communicate(timeout=30)
        self.assertEqual(process.returncode, 1, said)
        self.says(said, "goes on from there")

    def test_without_matplotlib_there_are_the_numbers_and_a_word_about_the_picture(self):
        # a Python as Debian's, which finds no packages
        python = self.folder / "python"
        python.write_text(f'#!/bin/sh\nexec {sys.executable} -S "$@"\n')
        python.chmod(0o700)
        if can_import(str(python), "matplotlib"):
            self.skipTest("this Python has matplotlib without its site-packages")
        said = self.reproduce(0, "fig7", environment={"C3RT_PYTHON": str(python)})
        self.says(said, "fig7.png is missing", "python3-matplotlib")
        self.assertEqual(len(self.results("fig7")["iterations"]), 3)
        self.assertFalse((self.folder / "fig7.png").exists())


if __name__ == "__main__":
    unittest.main()
