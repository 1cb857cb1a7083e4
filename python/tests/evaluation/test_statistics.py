"""What many runs amount to."""

import json
import math

import pytest

from c3rt.evaluation.statistics import distribution, figures, higher_is_better, mean, quantile, wilson

Z = 1.959963984540054


@pytest.mark.parametrize("successes, count", [(1, 10), (19, 20), (18, 20), (500, 1000)])
def test_the_ends_of_wilsons_interval_are_the_shares_that_are_1_96_deviations_from_what_was_seen(successes, count):
    # the defining equation: |p̂ − p| = z √(p (1 − p) / n)
    p = wilson(successes, count)
    seen = successes / count
    assert p.share == seen and p.low < seen < p.high
    for end in (p.low, p.high):
        assert abs(seen - end) == pytest.approx(Z * math.sqrt(end * (1 - end) / count), rel=1e-9)


def test_wilsons_interval_of_no_and_of_only_successes_ends_at_0_and_1_but_is_no_point():
    # closed form: 1 / (1 + z²/n)
    assert wilson(20, 20).high == 1.0
    assert wilson(20, 20).low == pytest.approx(1 / (1 + Z * Z / 20))  # 0.839
    assert wilson(0, 5).low == 0.0
    assert wilson(0, 5).high == pytest.approx(Z * Z / 5 / (1 + Z * Z / 5))
    assert wilson(1, 1).low == pytest.approx(0.20654, rel=1e-4)  # tabulated


def test_the_worst_of_a_distribution_is_at_the_end_that_nobody_wants_and_named_by_its_index():
    values = [3.0, 1.0, 5.0, 1.0]
    errors, shares = distribution(values, False), distribution(values, True)
    assert (errors.worst, errors.worst_index) == (5.0, 2)
    assert (shares.worst, shares.worst_index) == (1.0, 1)
    assert (errors.median, errors.mean, errors.count) == (2.0, 2.5, 4)


def test_quantiles_are_linear_between_neighbours():
    assert [quantile([1.0, 2.0, 4.0], share) for share in (0.0, 0.25, 0.5, 0.75, 1.0)] == [1.0, 1.5, 2.0, 3.0, 4.0]
    assert quantile([7.0], 0.95) == 7.0


def test_a_mean_is_summed_from_the_left_on_every_python():
    # (1 + 1e16) is 1e16, and then nothing is left; summed exactly it were 1/3
    assert mean([1.0, 1e16, -1e16]) == 0.0


def test_the_figures_of_a_report_are_all_of_its_numbers_by_path():
    report = json.loads("""{
        "scenario": "circle_slow", "seed": 7, "result": "passed", "passed": true,
        "criteria": [{"name": "loops_completed", "value": 3, "limit": 3, "met": true}],
        "loops_completed": 3, "loop_times_s": [19.0, 21.0, 20.0], "none_s": [],
        "objects": [{"rms_error_m": 0.004, "max_error_m": null}, {"rms_error_m": 0.005}],
        "planner": {"solve_time_s": {"p50": 0.0002, "max": 0.001}},
        "plant": {"reflexes": ["cartesian_reflex"], "real_time_factor": 2.5},
        "log_hash": "fnv1a64:0"}""")
    assert figures(report) == {
        "loops_completed": 3.0,
        "loop_times_s.median": 20.0,
        "loop_times_s.worst": 21.0,
        "objects.0.rms_error_m": 0.004,
        "objects.1.rms_error_m": 0.005,
        "planner.solve_time_s.p50": 0.0002,
        "planner.solve_time_s.max": 0.001,
        "plant.reflexes": 1.0,
        "plant.real_time_factor": 2.5,
    }


@pytest.mark.parametrize("name", ["objects.0.in_band_2cm", "loops_completed", "planner.rate_hz", "plant.success_rate_min",
                                  "plant.real_time_factor"])
def test_of_some_figures_more_is_better(name):
    assert higher_is_better(name)


@pytest.mark.parametrize("name", ["objects.0.max_error_m", "loop_times_s.worst", "planner.solve_time_s.p99",
                                  "vision.dropped_frames", "plant.reflexes", "duration_s"])
def test_of_the_others_less_is(name):
    assert not higher_is_better(name)
