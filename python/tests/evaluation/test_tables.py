"""Columns of tables and figures of reports, beside what is written down here by hand."""

import math

import pytest

from c3rt.evaluation.tables import figure, loop_times, mean_loop_time, number, numbers, read_columns, spread

REPORT = {"objects": [{"rms_error_m": 0.5}], "vision": {"rate_hz": None}, "loop_times_s": [19.04, 20.0], "passed": True}


def test_figures_are_found_by_their_path_and_what_is_not_there_is_no_number():
    assert figure(REPORT, "objects.0.rms_error_m") == 0.5
    for path in ("objects.1.rms_error_m", "objects.0.max", "vision.rate_hz", "nothing", "objects", "passed", "objects.x"):
        assert math.isnan(figure(REPORT, path)), path


def test_the_times_of_circles_are_one_line_and_their_mean():
    assert loop_times(REPORT) == "19.0, 20.0"
    assert mean_loop_time(REPORT) == pytest.approx(19.52)
    assert loop_times({"loop_times_s": []}) == "-"
    assert math.isnan(mean_loop_time({"loop_times_s": []}))


def test_quantiles_are_samples_by_nearest_rank():
    hundred = [float(value) for value in range(100, 0, -1)]
    assert spread(hundred) == {"p50": 50.0, "p95": 95.0, "p99": 99.0, "max": 100.0}
    assert spread([3.0]) == {"p50": 3.0, "p95": 3.0, "p99": 3.0, "max": 3.0}
    assert spread([]) == {"p50": None, "p95": None, "p99": None, "max": None}


def test_columns_are_read_by_name_and_an_empty_cell_is_no_number(tmp_path):
    file = tmp_path / "some.csv"
    file.write_text("t_s,name,x_m\n0,a,1.5\n0.5,b,\n")
    columns = read_columns(file, ["x_m", "t_s"])
    assert columns["t_s"] == [0.0, 0.5]
    assert columns["x_m"][0] == 1.5 and math.isnan(columns["x_m"][1])
    assert numbers(columns["x_m"]) == [1.5, None]
    assert number(math.inf) is None
    with pytest.raises(RuntimeError, match='some.csv: there is no column "y_m"'):
        read_columns(file, ["y_m"])
    file.write_text("t_s,x_m\n0,1\n0\n")
    with pytest.raises(RuntimeError, match="row 2 has 1 columns, expected 2"):
        read_columns(file, ["t_s"])
    file.write_text("")
    with pytest.raises(RuntimeError, match="no column"):
        read_columns(file, ["t_s"])
