#!/usr/bin/env python3
"""`c3rt campaign` as a person meets it, with real runs of a few simulated seconds. Needs nothing but Python 3.

    C3RT_PROGRAM=build/release/bin/c3rt campaign_test.py
"""
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAM = os.environ["C3RT_PROGRAM"]
# too short for a circle: it runs, but does not meet its criteria
SHORT = ["circle_fast", "--duration", "2"]


def can_import(python, module):
    try:
        return subprocess.run([python, "-c", f"import {module}"], capture_output=True).returncode == 0
    except OSError:
        return False


def processes_of(folder):
    """How many have a command line that names the folder."""
    count = 0
    for file in pathlib.Path("/proc").glob("[0-9]*/cmdline"):
        try:
            count += str(folder).encode() in file.read_bytes()
        except OSError:
            pass
    return count


class Campaign(unittest.TestCase):
    def setUp(self):
        self.folder = self.new_folder()

    def new_folder(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        return pathlib.Path(scratch.name)

    def campaign(self, status, *words, out=None, environment=None):
        """What it says on both streams."""
        ran = subprocess.run([PROGRAM, "campaign", *words, "--out", str(out or self.folder)], stdout=subprocess.PIPE,
                             stderr=subprocess.STDOUT, text=True, env={**os.environ, **(environment or {})})
        self.assertEqual(ran.returncode, status, ran.stdout)
        return ran.stdout

    def says(self, text, *parts):
        for part in parts:
            self.assertIn(part, text)

    def report(self, seed, folder=None):
        return json.loads(((folder or self.folder) / f"seed-{seed:04}/report.json").read_text())

    def test_mistakes_are_usage_errors_before_anything_is_started(self):
        for words, says in ((["no_such_scenario"], "circle_slow"),
                            (["circle_fast", "--seeds", "5..1"], "backwards"),
                            (["circle_fast", "--set", "planner.no_such_key=1"], "planner.no_such_key"),
                            (["circle_fast", "--address", "tcp://a:1"], "--engine dask"),
                            (["circle_fast", "--jobs", "0"], "--jobs"),
                            (["cart_pole", "--in-process"], "numerical example"),
                            (["circle_fast", "--engine", "ray"], "--engine")):
            with self.subTest(words):
                said = self.campaign(2, *words)
                self.says(said, says)
                self.assertTrue(said.splitlines()[-1].startswith("c3rt: error: "), said)
                self.assertNotIn("Traceback", said)
        self.assertFalse((self.folder / "seed-0001").exists())

    def test_two_seeds_at_once_a_report_each_one_table_and_the_same_bits_as_alone_then_kept(self):
        said = self.campaign(1, *SHORT, "--seeds", "1..2", "--jobs", "2")
        self.says(said, "0 of 2 passed", "criterion loops_completed", "c3rt run circle_fast --clock lockstep --seed ",
                  "--duration 2")
        one, two = self.report(1), self.report(2)
        self.assertEqual((one["seed"], two["seed"]), (1, 2))
        self.assertNotEqual(one["log_hash"], two["log_hash"])  # the noise
        table = json.loads((self.folder / "campaign.json").read_text())
        self.assertTrue(table["complete"])
        self.assertEqual(len(table["runs"]), 2)
        errors = [report["objects"][0]["rms_error_m"] for report in (one, two)]
        of_table = table["figures"]["objects.0.rms_error_m"]
        self.assertEqual((of_table["count"], of_table["worst"]), (2, max(errors)))
        self.assertAlmostEqual(of_table["mean"], sum(errors) / 2, places=12)
        self.assertIn("objects.0.rms_error_m", (self.folder / "campaign.md").read_text())
        # neither logs nor pictures unless wanted
        self.assertFalse((self.folder / "seed-0001/run.mcap").exists())
        self.assertFalse((self.folder / "seed-0001/path.png").exists())

        made = (self.folder / "seed-0002/report.json").stat().st_mtime_ns
        self.says(self.campaign(1, *SHORT, "--seeds", "1..2", "--jobs", "2"), "2 runs of an earlier call are kept")
        self.assertEqual((self.folder / "seed-0002/report.json").stat().st_mtime_ns, made)
        # other settings are another run
        self.assertNotIn("kept", self.campaign(1, *SHORT, "--seeds", "2", "--set", "planner.rate_hz=60"))
        self.assertNotEqual(self.report(2)["log_hash"], two["log_hash"])

        other = self.new_folder()
        self.campaign(1, *SHORT, "--seeds", "2", "--jobs", "1", "--logs", out=other)
        self.assertEqual(self.report(2, other)["log_hash"], two["log_hash"])
        self.assertTrue((other / "seed-0002/run.mcap").exists())

    def test_each_run_in_one_process_gives_the_bits_of_four_in_lockstep(self):
        apart = self.new_folder()
        self.campaign(1, *SHORT, "--seeds", "3", out=apart)
        self.says(self.campaign(1, *SHORT, "--seeds", "3,4", "--jobs", "2", "--in-process"),
                  "c3rt run circle_fast --in-process --seed ")
        self.assertEqual(self.report(3)["log_hash"], self.report(3, apart)["log_hash"])
        # nobody else was started
        self.assertFalse((self.folder / "seed-0003/logs/plant.log").exists())

    def test_a_run_whose_process_fails_is_status_3_with_the_end_of_its_log_and_is_made_again(self):
        programs = self.folder / "bin"
        programs.mkdir()
        for name in ("plant", "impedance", "planner", "vision"):
            file = programs / f"c3rt-{name}"
            file.write_text("#!/bin/sh\necho 'no model here'; exit 1\n")
            file.chmod(0o700)
        said = self.campaign(3, *SHORT, "--seeds", "1", environment={"C3RT_PROCESS_DIRECTORY": str(programs)})
        self.says(said, "seed-0001 exited with status 3", "no model here", "0 of 1 passed", "1 failed")
        self.assertNotIn("kept", self.campaign(1, *SHORT, "--seeds", "1"))

    def test_ctrl_c_ends_every_process_keeps_what_is_done_and_the_next_call_goes_on_from_there(self):
        self.campaign(1, *SHORT, "--seeds", "1")
        # seed 1 is of another call and is made again; the others would take minutes
        process = subprocess.Popen(
            [PROGRAM, "campaign", *SHORT, "--seeds", "1..4", "--jobs", "2", "--set", "timing.solve_time_s=0.0051", "--out",
             str(self.folder)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        deadline = time.monotonic() + 30
        while processes_of(self.folder / "seed-") < 2:
            self.assertLess(time.monotonic(), deadline, "no run has begun")
            time.sleep(0.02)
        process.send_signal(signal.SIGINT)
        said, _ = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 1, said)
        self.assertEqual(processes_of(self.folder), 0)
        self.says(said, "interrupted after", "goes on from there")

    def test_the_python_of_debian_is_enough_and_the_package_is_found_from_any_folder(self):
        environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
        for python in {"/usr/bin/python3", sys.executable}:
            ran = subprocess.run([os.path.abspath(PROGRAM), "campaign", "cart_pole", "--seeds", "1..2", "--duration", "0.2"],
                                 stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=self.folder,
                                 env={**environment, "C3RT_PYTHON": python})
            self.assertEqual(ran.returncode, 1, ran.stdout)
            self.assertTrue((self.folder / "out/campaign-cart_pole/campaign.json").is_file())

    def test_what_cannot_be_printed_is_status_3(self):
        with open("/dev/full", "w") as full:
            ran = subprocess.run([PROGRAM, "campaign", "cart_pole", "--seeds", "1", "--duration", "0.2", "--out",
                                  str(self.folder)], stdout=full, stderr=subprocess.PIPE, text=True)
        self.assertEqual(ran.returncode, 3)
        self.assertEqual(ran.stderr, "c3rt: error: cannot write to standard output: No space left on device\n")

    def test_without_python_it_is_a_usage_error_that_says_what_to_install(self):
        nobody = {"C3RT_PYTHON": "/bin/false"}
        self.says(self.campaign(2, *SHORT, environment=nobody), "Debian: python3)", "/bin/false", "C3RT_PYTHON")
        self.says(self.campaign(2, *SHORT, "--engine", "dask", environment=nobody), "python3-distributed", "C3RT_PYTHON")

    @unittest.skipUnless(any(can_import(python, "distributed") for python in ("python3", "/usr/bin/python3")),
                         "no Python here has the package distributed (Debian: python3-distributed)")
    def test_dask_makes_the_same_runs_on_its_workers(self):
        here = self.new_folder()
        self.campaign(1, *SHORT, "--seeds", "1..2", "--jobs", "2", "--engine", "dask")
        self.campaign(1, *SHORT, "--seeds", "2", out=here)
        self.assertEqual(self.report(2)["log_hash"], self.report(2, here)["log_hash"])
        self.says(self.campaign(1, *SHORT, "--seeds", "1..2", "--jobs", "2", "--engine", "dask"),
                  "2 runs of an earlier call are kept")
        # a scheduler that is not there
        said = self.campaign(2, *SHORT, "--seeds", "3", "--engine", "dask", "--address", "tcp://127.0.0.1:9", out=here)
        self.says(said, "no Dask scheduler at tcp://127.0.0.1:9")


if __name__ == "__main__":
    unittest.main()
