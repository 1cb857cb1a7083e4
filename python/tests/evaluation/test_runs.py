"""Runs of a stand-in for the program c3rt: which are made, which are kept, and what is told of their ends."""

import pathlib
import sys

import pytest

from c3rt.evaluation.runs import EngineSettings, RunSpec, run_all, run_settings
from c3rt.evaluation.scenario import read_scenario
from c3rt.evaluation.status import DONE, PROCESS_FAILED, UsageError

STAND_IN = '''#!{python}
import json, os, pathlib, sys, time
words = sys.argv[1:]
options = dict(word.lstrip("-").partition("=")[::2] for word in words[2:])
if words[0] == "scenario":
    if words[1] == "wrong":
        print("c3rt: error: wrong.yaml:1: x: expected a number", file=sys.stderr)
        sys.exit(2)
    text = pathlib.Path({text!r}).read_text()
    print(json.dumps({{"file": "/there/" + words[1] + ".yaml", "is_example": words[1] == "example", "own_text": text,
                       "text": text, "values": {{}}, "files": [{text!r}]}}))
    sys.exit(0)
out = pathlib.Path(options["out"])
print("a word of", options["seed"], flush=True)
how = {{"3": "crash", "4": "refuse", "5": "nothing", "6": "interrupted", "7": "last"}}.get(options["seed"], "passed")
if how == "crash":
    os.kill(os.getpid(), 11)
if how == "refuse":
    sys.exit(2)
if how == "last":
    time.sleep(60)
if how != "nothing":
    (out / "report.json").write_text(json.dumps({{"result": how, "words": words, "made_ns": time.time_ns()}}))
sys.exit(1 if how == "interrupted" else 0)
'''


@pytest.fixture
def program(tmp_path):
    file = tmp_path / "c3rt"
    (tmp_path / "scenario.txt").write_text("x: 1\n")
    file.write_text(STAND_IN.format(python=sys.executable, text=str(tmp_path / "scenario.txt")))
    file.chmod(0o700)
    return file


def make(program, *specs, stop=lambda: False, fresh=False):
    settings = EngineSettings(str(program), fresh=fresh, at_once=4)
    return run_all(specs, run_settings(settings, stop), program.parent / "runs", "test")


def spec(seed=1, **more):
    return RunSpec(f"seed-{seed}", "some", seed, **more)


def test_a_run_is_kept_until_something_that_it_depends_on_changes(program):
    def made(one=spec(), **how):
        return make(program, one, **how)[0].report["made_ns"]

    first = made()
    assert made() == first
    for changed in (spec(overrides=["a=1"]), spec(duration=2.0), spec(logs=True), spec(in_process=True)):
        other = made(changed)
        assert other != first and made(changed) == other
    first = made()
    again = made(fresh=True)
    assert again != first and made() == again
    (program.parent / "scenario.txt").write_text("x: 2\n")
    changed = made()
    assert changed != again and made() == changed
    (program.parent / "c3rt-planner").write_text("another build")
    assert made() != changed


def test_results_come_in_the_order_asked_for_and_the_words_are_those_of_the_spec(program):
    results = make(program, spec(9, duration=2.5, overrides=["a=1"]), spec(8, in_process=True, logs=True, pictures=True),
                   RunSpec("example", "example", 2, duration=3.0))
    assert [result.report["words"][:-1] for result in results] == [
        ["run", "/there/some.yaml", "--seed=9", "--clock=lockstep", "--domain=any", "--no-logs", "--no-pictures", "--set=a=1",
         "--set=task.duration_s=2.5"],
        ["run", "/there/some.yaml", "--seed=8", "--in-process"],
        ["run", "/there/example.yaml", "--seed=2", "--set=control.duration_s=3"],
    ]
    assert [result.status for result in results] == [DONE] * 3
    assert (results[0].folder / "run.log").read_text() == "a word of 9\n"


def test_what_went_wrong_is_said_with_the_end_of_the_log_and_is_made_again(program):
    crashed, refused, nothing, interrupted = make(program, spec(3), spec(4), spec(5), spec(6))
    assert {result.status for result in (crashed, refused, nothing, interrupted)} == {PROCESS_FAILED}
    assert crashed.failure.startswith("seed-3 was killed by signal 11 (Segmentation fault); the end of its log (")
    assert crashed.failure.endswith("a word of 3\n")
    assert "seed-4 exited with status 2" in refused.failure
    assert "no report.json in" in nothing.failure
    assert interrupted.failure == "seed-6 was interrupted by a signal" and interrupted.report is None
    assert not (crashed.folder / "run.json").exists() and not (interrupted.folder / "run.json").exists()


def test_a_stop_ends_what_runs_and_keeps_what_is_done(program):
    done = program.parent / "runs/seed-1/run.json"
    results = make(program, spec(1), spec(7), stop=done.exists)
    assert [result.spec.seed for result in results] == [1]
    words = str(program.parent / "runs/seed-7").encode()
    assert not [file for file in pathlib.Path("/proc").glob("[0-9]*/cmdline") if words in _bytes(file)]


def _bytes(file):
    try:
        return file.read_bytes()
    except OSError:
        return b""


def test_mistakes_are_usage_errors_and_the_programs_own_sentence(program):
    with pytest.raises(UsageError, match="^wrong.yaml:1: x: expected a number$"):
        read_scenario(str(program), "wrong")
    with pytest.raises(UsageError, match="example is a numerical example"):
        make(program, RunSpec("x", "example", in_process=True))
    with pytest.raises(UsageError, match="--address: only with --engine dask"):
        run_settings(EngineSettings(str(program), address="tcp://a:1"), lambda: False)
    assert not (program.parent / "runs").exists()
