"""Which numbers c3rt tune looks for, and how they are seen."""

import pytest

from c3rt.evaluation.search import LINEAR, LOG, WHOLE, assignments, from_unit, parse_parameter, start, to_unit
from c3rt.evaluation.status import UsageError


def test_a_number_is_a_key_or_several_with_a_range():
    parameter = parse_parameter(LOG, "a.b,a.c=1e-2..1e+2")
    assert (parameter.keys, parameter.low, parameter.high) == (["a.b", "a.c"], 0.01, 100.0)
    assert parse_parameter(LINEAR, "a=-3..-1").low == -3.0


@pytest.mark.parametrize("scale, text, says", [
    *((LINEAR, wrong, "--linear: expected KEY=LOW..HIGH")
      for wrong in ("", "a", "a=1", "a=1..", "=1..2", "a,=1..2", "a=1..x", "a=nan..1", "a=1_0..20")),
    (LINEAR, "a=2..1", "lower end"),
    (LOG, "a=0..1", "above 0"),
    (WHOLE, "a=1..2.5", "whole numbers"),
])
def test_what_is_no_such_range_is_refused(scale, text, says):
    with pytest.raises(UsageError, match=says):
        parse_parameter(scale, text)


def test_a_range_is_0_to_1_by_halves_by_factors_by_whole_numbers():
    linear, log, whole = (parse_parameter(LINEAR, "a=2..6"), parse_parameter(LOG, "a=0.1..1000"),
                          parse_parameter(WHOLE, "a=1..5"))
    assert from_unit(linear, 0.25) == pytest.approx(3.0)
    assert from_unit(log, 0.25) == pytest.approx(1.0)
    assert [from_unit(whole, unit) for unit in (0.3, 0.375, 0.125, 0.625)] == [2.0, 3.0, 2.0, 4.0]  # of 2.2, 2.5, 1.5, 3.5
    for parameter in (linear, log):
        for unit in (0.0, 0.3, 1.0):
            assert to_unit(parameter, from_unit(parameter, unit)) == pytest.approx(unit, abs=1e-12)
    assert from_unit(log, 1.0 + 1e-9) <= 1000.0 and from_unit(log, -1.0) >= 0.1


SCENARIO = {"a": {"b": "10", "c": "10", "d": "3", "list": ["7"], "word": "fast", "none": None}}


def begin(scale, text):
    return start([parse_parameter(scale, text)], SCENARIO, "s.yaml")


def test_the_search_begins_where_the_scenario_is():
    assert begin(LOG, "a.b,a.c=1..1000") == [pytest.approx(1 / 3)]
    assert begin(LINEAR, "a.list.0=6..8") == [pytest.approx(0.5)]


@pytest.mark.parametrize("text, says", [
    ("a.x=1..2", "a.x: no such key in s.yaml"),
    ("a.none=1..2", "a.none: no such key in s.yaml"),
    ("a.list.1=1..2", "no such key"),
    ("a.word=1..2", 'expected a number in s.yaml, got "fast"'),
    ("a=1..2", "expected a number in s.yaml, got a mapping"),
    ("a.list=1..2", "got a list of 1"),
    ("a.b=1..2", "in 1 to 2, got 10"),
    ("a.b,a.d=1..20", "the value of a.b, 10, got 3"),
    ("a.b,a.b=1..20", "named twice"),
])
def test_what_does_not_fit_is_said(text, says):
    with pytest.raises(UsageError, match=says):
        begin(LINEAR, text)


def test_a_candidate_is_assignments_for_set():
    parameters = [parse_parameter(LOG, "a.b,a.c=1e4..1e6"), parse_parameter(WHOLE, "a.d=1..5")]
    assert assignments(parameters, [0.5, 1.0]) == ["a.b=100000", "a.c=100000", "a.d=5"]
