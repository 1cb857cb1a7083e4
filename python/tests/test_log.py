"""c3rt.log: recordings as tables."""

import csv
import os
import subprocess

import numpy as np
import pytest

pytest.importorskip("pandas")
import c3rt.log  # noqa: E402

PROGRAM = os.environ.get("C3RT_PROGRAM")
if not PROGRAM:
    pytest.skip("C3RT_PROGRAM names no c3rt that could make a recording", allow_module_level=True)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run") / "out"
    subprocess.run([PROGRAM, "run", "push_t", "--in-process", "--duration", "1", "--no-pictures", "--out", folder],
                   capture_output=True, check=False)
    return folder


def test_a_recording_has_the_numbers_of_its_exported_tables(run):
    recording = c3rt.log.read(run / "run.mcap")
    subprocess.run([PROGRAM, "export", run / "run.mcap", "--out", run / "tables"], capture_output=True, check=True)
    for topic, numbers in (("robot/state", ["q_rad_3", "p_WE_m_2", "command_success_rate"]), ("plan", ["knots_1_p_WE_m_0"]),
                           ("object/estimate", ["p_WB_m_1", "q_WB_0"]), ("sim/scene", ["objects_0_p_WB_m_0"])):
        frame = recording[topic]
        with open(run / "tables" / (topic.replace("/", "_") + ".csv")) as table:
            rows = list(csv.DictReader(table))
        assert len(frame) == len(rows)
        assert list(frame["seq"]) == [int(row["seq"]) for row in rows]
        for name in numbers:
            np.testing.assert_allclose(frame[name], [float(row[name]) for row in rows], rtol=1e-8, atol=1e-12)


def test_a_recording_says_of_which_run_it_is(run):
    recording = c3rt.log.read(run / "run.mcap")
    assert recording.metadata["run"]["scenario"] == "push_t"
    assert recording.report["seed"] == 1
    assert "task:" in recording.scenario
    assert recording.cut_off == ""
    assert recording.other == {}


def test_time_begins_at_the_first_sample_and_enumerators_are_words(run):
    recording = c3rt.log.read(run / "run.mcap")
    assert min(frame["time_s"].min() for frame in recording.values()) == 0.0
    assert recording["robot/state"]["time_s"].iloc[-1] == pytest.approx(1.0, abs=0.05)
    assert set(recording["robot/state"]["mode"]) == {"idle", "move"}


def test_what_is_long_is_one_column_of_arrays(run):
    debug = c3rt.log.read(run / "run.mcap", topics=["planner/debug"])["planner/debug"]
    assert debug["states"].iloc[0].shape == (480,)


def test_topics_choose_and_a_topic_without_samples_is_named(run):
    assert set(c3rt.log.read(run / "run.mcap", topics=["plan"])) == {"plan"}
    with pytest.raises(ValueError, match="topics: plans: no samples in"):
        c3rt.log.read(run / "run.mcap", topics=["plans"])
    with pytest.raises(TypeError, match="topics: expected a list of names, got the text 'plan'"):
        c3rt.log.read(run / "run.mcap", topics="plan")
    with pytest.raises(KeyError, match="expected one of .*robot/state.*, got 'robot'"):
        c3rt.log.read(run / "run.mcap")["robot"]


def test_of_a_recording_that_was_cut_off_all_that_is_left_is_read(run, tmp_path):
    whole = (run / "run.mcap").read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole[: len(whole) // 2])
    recording = c3rt.log.read(cut)
    assert recording.cut_off == "it is cut off"
    assert 0 < len(recording["robot/state"]) < len(c3rt.log.read(run / "run.mcap")["robot/state"])


def test_what_is_no_recording_is_refused(tmp_path):
    (tmp_path / "a.mcap").write_text("name: push_t")
    with pytest.raises(ValueError, match="a.mcap: it does not begin as an MCAP does"):
        c3rt.log.read(tmp_path / "a.mcap")
    with pytest.raises(ValueError, match="none.mcap: No such file"):
        c3rt.log.read(tmp_path / "none.mcap")


def test_a_scenario_runs_and_gives_frames_and_report(run):
    again = c3rt.run("push_t", duration=1.0)
    assert again.report["log_hash"] == c3rt.log.read(run / "run.mcap").report["log_hash"]
    assert len(again["robot/state"]) >= 1000


def test_a_run_takes_seed_and_settings_and_keeps_what_is_asked_for(tmp_path):
    other = c3rt.run("push_t", seed=2, duration=0.5, settings={"task.goals_m": [[0.5, 0.1]], "planner.rate_hz": 50}, out=tmp_path / "out")
    assert other.report["seed"] == 2
    assert "rate_hz: 50" in other.scenario
    assert (tmp_path / "out" / "report.json").is_file()


def test_what_is_wrong_with_a_run_is_said(monkeypatch):
    with pytest.raises(ValueError, match="no_such_scenario"):
        c3rt.run("no_such_scenario")
    with pytest.raises(ValueError, match="planner.rate"):
        c3rt.run("push_t", settings={"planner.rate": 50})
    with pytest.raises(TypeError, match="seed: expected a whole number, got 1.5"):
        c3rt.run("push_t", seed=1.5)
    monkeypatch.delenv("C3RT_PROGRAM")
    monkeypatch.setenv("PATH", "")
    with pytest.raises(FileNotFoundError, match="C3RT_PROGRAM"):
        c3rt.run("push_t")
