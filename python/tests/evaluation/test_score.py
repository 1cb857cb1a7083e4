"""Which of two candidates is better."""

import math
import pathlib

import pytest

from c3rt.evaluation.runs import RunResult, RunSpec
from c3rt.evaluation.score import Score, ranks, score, text
from c3rt.evaluation.status import DONE, PROCESS_FAILED


def result(value, limit, time):
    return RunResult(RunSpec("x", "x"), pathlib.Path(), DONE, report={
        "criteria": [{"name": "time", "value": value, "limit": limit, "met": value is not None and value <= limit}],
        "time_s": time})


def failed():
    return RunResult(RunSpec("x", "x"), pathlib.Path(), PROCESS_FAILED)


def test_runs_that_failed_count_before_criteria_criteria_before_the_figure():
    met, slower, missed, broken = (score(results, "time_s", False) for results in (
        [result(9, 10, 9)], [result(9.5, 10, 9.5)], [result(20, 10, 1)], [result(9, 10, 9), failed()]))
    assert met < slower < missed < broken
    assert not met < met


def test_a_criterion_is_missed_by_its_share_a_value_that_is_not_there_wholly():
    assert score([result(20, 10, 1)], "time_s", False).shortfall == pytest.approx(0.5)
    assert score([result(10.001, 10, 1)], "time_s", False).shortfall == pytest.approx(0.01)
    assert score([result(None, 0, 1), result(9, 10, 1)], "time_s", False).shortfall == 1.0


def test_a_figure_is_the_mean_over_the_runs_one_that_does_not_give_it_makes_it_infinite():
    runs = [result(1, 2, 4), result(1, 2, 8)]
    assert score(runs, "time_s", False).figure == pytest.approx(6.0)
    assert score(runs, "time_s", True).figure == pytest.approx(-6.0)
    del runs[0].report["time_s"]
    assert math.isinf(score(runs, "time_s", True).figure)
    assert text(score(runs[:1], "time_s", True), "time_s", True) == "all criteria met, time_s not reached"
    assert text(score([failed()], "time_s", True), "time_s", True) == "1 runs failed"


def test_ranks_are_places_and_equals_share_one():
    a, b, c = Score(0, 0.0, 1.0), Score(0, 0.0, 2.0), Score(1, 0.0, 0.0)
    assert ranks([c, b, a, b]) == [3.0, 1.0, 0.0, 1.0]
