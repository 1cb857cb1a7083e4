"""The suite of objects, with a stand-in for the program c3rt: what its table says of reports that are known."""

import json

import pytest

from c3rt.evaluation import reproduce
from c3rt.evaluation.reproduction import Settings

# seed n reaches the goal after n seconds, and stays n mm and half a turn off; seed 4 does not reach it
STAND_IN = '''#!{python}
import json, pathlib, sys
words = sys.argv[1:]
if words[0] == "scenario":
    print(json.dumps({{"file": "/there/" + words[1] + ".yaml", "is_example": False, "own_text": "", "text": "", "values": {{}},
                       "files": []}}))
    sys.exit(0)
options = dict(word.lstrip("-").partition("=")[::2] for word in words[2:])
seed = int(options["seed"])
reached = seed != 4
task = {{"goal_time_s": float(seed) if reached else None, "end_position_error_m": 0.001 * seed,
        "end_angle_error_rad": 3.141592653589793}}
report = {{"result": "passed" if reached else "criteria not met", "criteria": [], "task": task, "words": words}}
(pathlib.Path(options["out"]) / "report.json").write_text(json.dumps(report))
sys.exit(0 if reached else 1)
'''


def test_each_case_has_its_share_of_seeds_that_reached_the_goal_and_what_was_left(program, capsys):
    out = program.parent / "out"
    settings = Settings(str(program), what="push_anything", out=str(out), quick=True, seeds="1..4")
    assert reproduce.run(settings, lambda: False) == 0
    told = json.loads((out / "push_anything.json").read_text())
    assert [case["scenario"] for case in told["cases"]] == ["push_box", "push_t"]
    for case in told["cases"]:
        assert (case["reached"], case["runs"]) == (3, 4)
        assert case["goal_times_s"] == [1.0, 2.0, 3.0]
        assert case["end_position_errors_mm"] == pytest.approx([1.0, 2.0, 3.0, 4.0])
        assert case["end_angle_errors_deg"] == pytest.approx([180.0] * 4)
    lines = capsys.readouterr().out.splitlines()
    # Wilson's interval of 3 in 4 is tabulated: 30.1 to 95.4 %; 95 % of 1, 2, 3 is 2.9
    assert lines[3].split() == "box 3 of 4 30 to 95 2; 2.9 2.5; 3.85 180; 180 -".split()
    assert lines[4].endswith("mean 26.9, median 22.8") and lines[-1] == str(out / "push_anything.json")
    words = json.loads((out / "runs/push_anything-01-push_t-0002/report.json").read_text())["words"]
    assert "--in-process" in words and "--set=task.duration_s=6" in words


def test_a_wish_to_end_is_told_and_the_next_call_goes_on(program, capsys):
    settings = Settings(str(program), what="push_anything", out=str(program.parent / "out"), quick=True, seeds="1")
    assert reproduce.run(settings, lambda: True) == 1
    assert "the same command goes on from there" in capsys.readouterr().err
    assert not (program.parent / "out/push_anything.json").exists()
    assert reproduce.run(settings, lambda: False) == 0
