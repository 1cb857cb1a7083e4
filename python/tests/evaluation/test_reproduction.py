"""What every table and figure has, with a stand-in for the program c3rt."""

import json

import pytest

from c3rt.evaluation.groups import Group, Interrupted
from c3rt.evaluation.reproduction import Example, Reproduction, Settings
from c3rt.evaluation.targets.examples import _intervals
from c3rt.evaluation.targets.paths import draw_paths

STAND_IN = '''#!{python}
import json, os, pathlib, sys, time
words = sys.argv[1:]
if words[0] == "scenario":
    print(json.dumps({{"file": "/there/" + words[1] + ".yaml", "is_example": words[1] == "example", "own_text": "", "text": "",
                       "values": {{}}, "files": []}}))
    sys.exit(0)
options = dict(word.lstrip("-").partition("=")[::2] for word in words[1:])
out = pathlib.Path(options.get("out") or options["series"])
if words[0] == "gap":
    if words[1] == "none":
        sys.exit(1)
    if words[1] == "long":
        (out / "begun").touch()
        time.sleep(60)
    (out / "gap.json").write_text(json.dumps({{"words": words, "made_ns": time.time_ns()}}))
    sys.exit(4)
if words[0] == "report":
    # a square of 2 m, and an object that stays on its first corner until it is lost
    (out / "path.csv").write_text("x_m,y_m\\n0,0\\n2,0\\n2,2\\n0,2\\n0,0\\n")
    (out / "objects.csv").write_text("t_s,object_0_x_m,object_0_y_m,object_0_error_m\\n0,0,0,0\\n1,9,0,7\\n")
    sys.exit(1)
(out / "report.json").write_text(json.dumps({{"result": "passed", "log_hash": "1234", "words": words}}))
'''


def of(program, stop=lambda: False, **more):
    return Reproduction(Settings(str(program), what="test", out=str(program.parent / "out"), **more), stop)


def gap(reproduction, *words, inputs="some"):
    folder = reproduction.call("gap", ["gap", *words, "--out={folder}"], inputs, "gap.json")
    return json.loads((folder / "gap.json").read_text())["made_ns"]


def test_an_answer_is_kept_until_something_that_it_depends_on_changes(program, capfd):
    first = gap(of(program), "a")
    assert gap(of(program), "a") == first
    assert "gap: kept from an earlier run" in capfd.readouterr().err
    second = gap(of(program), "b")
    assert second != first
    third = gap(of(program), "b", inputs="other")
    assert third != second
    assert gap(of(program), "b", inputs="other") == third
    assert gap(of(program, fresh=True), "b", inputs="other") != third
    program.write_text(program.read_text() + "# another\n")
    assert gap(of(program), "b", inputs="other") != third


def test_an_answer_that_was_cut_short_is_made_again(program):
    first = gap(of(program), "a")
    note = program.parent / "out/runs/test-gap/call.json"
    note.write_text('{"key": {')
    assert gap(of(program), "a") != first


def test_a_call_without_an_answer_says_what_was_called_and_where_its_words_are(program):
    with pytest.raises(RuntimeError, match="c3rt gap ended with status 1; the end of its log .*call.log"):
        gap(of(program), "none")


def test_a_wish_to_end_is_heard_before_a_call_and_within_it_and_kept_answers_are_given_still(program):
    first = gap(of(program), "a")
    assert gap(of(program, stop=lambda: True), "a") == first
    with pytest.raises(Interrupted):
        gap(of(program, stop=lambda: True), "b")
    begun = program.parent / "out/runs/test-gap/begun"
    with pytest.raises(Interrupted):
        gap(of(program, stop=begun.exists), "long")
    assert not (program.parent / "out/runs/test-gap/call.json").exists()


def test_an_example_is_one_trial_with_its_own_options_and_short_where_it_is_a_look(program):
    run = of(program).examples([Example("one", "example", ["c3.rho=2"], ["--exact=3"])])[0]
    assert run.report["words"][2:-1] == ["--seed=1", "--exact=3", "--set=c3.rho=2", "--set=start.trials=1"]
    assert run.folder.name == "test-one"
    run = of(program, quick=True).examples([Example("one", "example", ["c3.rho=2"])])[0]
    assert run.report["words"][2:-1] == ["--seed=1", "--set=c3.rho=2", "--set=start.trials=1", "--set=control.duration_s=0.3"]


def test_paths_are_drawn_at_one_scale_about_their_middle_and_a_lost_object_does_not_shrink_them(program):
    reproduction = of(program)
    run = reproduction.runs([Group("one", "some", logs=True, in_process=True)])[0]
    figure = draw_paths(reproduction, "title", [("a", run), ("b", run)])
    assert figure["columns"] == 2 and [panel["title"] for panel in figure["panels"]] == ["a", "b"]
    for panel in figure["panels"]:
        # in x from 0 to 0.2 m beyond the path, in y the path: a square of 2.2 m and 3 cm about it
        assert panel["x_limits"] == pytest.approx([1.1 - 1.13, 1.1 + 1.13])
        assert panel["y_limits"] == pytest.approx([1.0 - 1.13, 1.0 + 1.13])
        assert panel["curves"][1]["x"] == [0.0, 9.0]


def test_a_finger_pushes_while_its_force_is_above_a_thousandth_of_a_newton():
    times = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]
    assert _intervals(times, [5.0, 5.0, 1e-4, 2.0, 0.0, 9.0]) == [(0.0, 2.0), (3.0, 4.0)]
    assert _intervals(times, [0.0] * 6) == []
    assert _intervals(times, [float("nan")] * 6) == []
