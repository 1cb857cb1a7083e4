"""The one table of a campaign."""

import pathlib

from c3rt.evaluation.runs import RunResult, RunSpec, replay_command
from c3rt.evaluation.status import CRITERION_FAILED, DONE, PROCESS_FAILED
from c3rt.evaluation.summary import rows, summarise, to_json, verdict


def result(seed, band, error):
    """A run with two criteria (band at least 0.98, largest error at most 0.02) and one more figure."""
    band_met, error_met = band >= 0.98, error <= 0.02
    passed = band_met and error_met
    return RunResult(
        RunSpec("seed", "circle_slow", seed, ["planner.rate_hz=50"]), pathlib.Path("out"),
        status=DONE if passed else CRITERION_FAILED,
        report={
            "result": "passed" if passed else "criteria not met",
            "criteria": [{"name": "in_band_2cm", "value": band, "limit": 0.98, "met": band_met},
                         {"name": "path_error_max_m", "value": error, "limit": 0.02, "met": error_met}],
            "objects": [{"max_error_m": error}],
        })


def crashed(seed):
    return RunResult(RunSpec("seed", "circle_slow", seed), pathlib.Path("out"), status=PROCESS_FAILED,
                     failure="planner was killed by signal 11")


def test_the_summary_counts_a_failed_process_as_no_success_and_keeps_it_out_of_the_figures():
    summary = summarise([result(1, 1.0, 0.01), result(2, 0.9, 0.03), crashed(3)])
    assert (summary.success.successes, summary.missed, summary.failed, summary.success.count) == (1, 1, 1, 3)
    band, error = summary.criteria
    assert (band.met.successes, band.met.count) == (1, 2)
    assert (band.values.values.worst, band.values.worst_seed) == (0.9, 2)  # more is better
    assert error.values.values.worst == 0.03
    assert [(figure.name, figure.values.count) for figure in summary.figures] == [("objects.0.max_error_m", 2)]


def test_a_campaign_of_failed_runs_alone_has_no_figures():
    summary = summarise([crashed(1), crashed(2)])
    assert (summary.failed, summary.criteria, summary.figures) == (2, [], [])


def test_worth_a_look_is_what_failed_then_what_missed_most_then_the_first_criterions_worst():
    good, better = result(1, 1.0, 0.010), result(2, 1.0, 0.005)
    one, both = result(3, 0.95, 0.01), result(4, 0.97, 0.05)
    assert summarise([good, better]).worst == 0
    assert summarise([better, good]).worst == 1
    assert summarise([good, one, both]).worst == 2
    assert summarise([one, result(5, 0.90, 0.01)]).worst == 1
    assert summarise([both, crashed(6), one]).worst == 1


def test_criteria_come_first_in_the_table_and_the_verdict_has_the_interval():
    summary = summarise([result(1, 1.0, 0.01), result(2, 1.0, 0.02)])
    table = rows(summary)
    assert len(table) == 4
    assert table[1][:2] == ["criterion in_band_2cm (limit 0.98)", "2 of 2"]
    assert table[3][0] == "objects.0.max_error_m"
    assert table[3][4] == "0.015"  # the median
    assert verdict(summary) == "2 of 2 passed (100 %, 95 % confidence: 34 to 100 %)"


def test_the_json_tells_every_run_and_how_to_see_the_worst_one_again():
    results = [result(7, 0.5, 0.01), crashed(8)]
    told = to_json(summarise(results), results)
    assert told["worst"] == {"seed": 8, "command": "c3rt run circle_slow --clock lockstep --seed 8"}
    assert told["runs"][0]["criteria_missed"] == ["in_band_2cm"]
    assert "signal 11" in told["runs"][1]["result"]
    assert told["figures"]["objects.0.max_error_m"]["worst_seed"] == 7


def test_the_command_of_a_run_again_quotes_what_a_shell_would_take_apart():
    spec = RunSpec("x", "circle_slow", 3, ["planner.rate_hz=50", "task.center_m=[0.5, 0]"], 12.5)
    assert replay_command(spec) == ("c3rt run circle_slow --clock lockstep --seed 3 --duration 12.5 --set planner.rate_hz=50 "
                                    "--set 'task.center_m=[0.5, 0]'")
    assert replay_command(RunSpec("x", "circle_slow", 4, duration=2.0, in_process=True)) == (
        "c3rt run circle_slow --in-process --seed 4 --duration 2")
    assert replay_command(RunSpec("x", "cart_pole", 4, is_example=True)) == "c3rt run cart_pole --seed 4"
