"""c3rt.client beside real processes, in lockstep: what docs/clients.md promises, with its own programs. Run by pytest.

C3RT_PROGRAM names c3rt, PYTHONPATH has the package.
"""
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np
import pytest

pytest.importorskip("cyclonedds", reason="the package cyclonedds could not be had")

from c3rt.client import Client, Estimate, Estimator, Refused, Thresholds  # noqa: E402
from c3rt.v2 import RobotState  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "support"))
from own_domain import take_domain  # noqa: E402

PROGRAM = os.environ["C3RT_PROGRAM"]
DOMAIN = take_domain()
PATIENCE = 120  # of a busy machine


@pytest.fixture(autouse=True)
def runtime(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))


def c3rt(*words, status=0):
    ran = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True, timeout=PATIENCE)
    assert ran.returncode == status, ran.stdout + ran.stderr
    return ran.stdout


def example(*words, program="python_planner/planner.py"):
    return subprocess.Popen([sys.executable, str(ROOT / "examples" / program), *words, "--domain", str(DOMAIN)],
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def ends(process):
    words, _ = process.communicate(timeout=PATIENCE)
    assert (process.returncode, words) == (0, "")


def run(scenario, without, out, *words, status=0, logs=False):
    said = c3rt("run", scenario, "--without", without, "--clock", "lockstep", "--domain", DOMAIN, "--no-pictures",
                *([] if logs else ["--no-logs"]), "--out", out, *words, status=status)
    return json.loads((out / "report.json").read_text()), said


def test_a_planner_of_one_s_own_rolls_the_ball_and_gives_the_same_bits_twice(tmp_path):
    hashes = []
    for turn in ("first", "second"):
        planner = example("--clock", "lockstep")
        report, said = run(ROOT / "examples/python_planner/roll.yaml", "planner", tmp_path / turn)
        words, _ = planner.communicate(timeout=PATIENCE)
        assert (planner.returncode, words) == (0, "")
        hashes.append(report["log_hash"])
    assert report["result"] == "passed" and "your planner" in said
    client = report["clients"][0]
    assert client["process"] == "planner" and client["problems"] == []
    assert client["rate_hz"] == pytest.approx(100.0, rel=0.01) and client["age_s"]["max"] < 0.01
    assert hashes[0] == hashes[1]


class FromTruth(Estimator):
    """Where the objects are, as the plant says."""

    def estimate(self, time_s, truth):
        return [Estimate(i, body.p_WB_m, body.q_WB, body.v_WB_m_per_s) for i, body in enumerate(truth.objects[: truth.object_count])]


class OwnImages(FromTruth):
    """The same without the plant's exposures, as a camera of one's own."""

    of_exposures = False

    def estimate(self, time_s, truth):
        return [] if truth is None else super().estimate(time_s, truth)


@pytest.mark.parametrize("kind", [FromTruth, OwnImages])
def test_an_estimator_or_a_camera_of_one_s_own_takes_vision_s_place(tmp_path, kind):
    vision = threading.Thread(target=kind().run, kwargs={"domain": DOMAIN, "clock": "lockstep"})
    vision.start()
    report, _ = run("circle_slow", "vision", tmp_path / "out", "--duration", "2", status=1)
    vision.join(PATIENCE)
    assert not vision.is_alive()
    client = report["clients"][0]
    assert (client["process"], client["topic"], client["problems"]) == ("vision", "object/estimate", [])
    assert client["rate_hz"] == pytest.approx(80.0, rel=0.01)
    if kind is FromTruth:
        assert report["vision"]["dropped_frames"] <= 1 and report["vision"]["error_m"]["max"] < 1e-9


def test_the_example_s_estimator_is_a_millimetre_wrong_and_the_ball_rolls(tmp_path):
    estimator = example("--clock", "lockstep", program="estimator/estimator.py")
    report, _ = run("circle_slow", "vision", tmp_path / "out", "--duration", "3", status=1, logs=True)
    ends(estimator)
    assert report["clients"][0]["problems"] == [] and report["plant"]["reflexes"] == []
    assert 3e-4 < report["vision"]["error_m"]["p50"] < 3e-3 and report["vision"]["error_m"]["max"] < 6e-3
    scene = recorded(tmp_path / "out", "sim/scene")
    assert np.ptp(scene["objects_0_p_WB_m_0"]) > 0.02


def recorded(folder, topic):
    log = pytest.importorskip("c3rt.log", reason="pandas is the extra [log]")
    return log.read(folder / "run.mcap", topics=[topic])[topic]


def picture(file, x, y):
    """A ball that a camera straight above sees, as examples/image_files/camera.py has it."""
    rows, columns = np.mgrid[0:600, 0:400]
    on_ball = np.hypot(0.35 + 0.001 * (columns + 0.5) - x, 0.3 - 0.001 * (rows + 0.5) - y) < 0.0315
    file.write_bytes(b"P5\n400 600\n255\n" + np.where(on_ball, 220, 32).astype(np.uint8).tobytes())


def test_the_example_s_camera_finds_the_ball_of_each_file(tmp_path):
    files = tmp_path / "files"
    files.mkdir()
    drawn = [(0.55 + 0.001 * i, 0.05) for i in range(25)]
    for i, (x, y) in enumerate(drawn):
        picture(files / f"{i:03}.pgm", x, y)
    camera = example(str(files), "--clock", "lockstep", program="image_files/camera.py")
    run("circle_slow", "vision", tmp_path / "out", "--duration", "0.6", status=1, logs=True)
    ends(camera)
    seen = recorded(tmp_path / "out", "object/estimate")
    np.testing.assert_allclose(seen[["p_WB_m_0", "p_WB_m_1"]].iloc[:25], drawn, atol=2e-4)
    assert seen["v_WB_m_per_s_0"].iloc[1:25].mean() == pytest.approx(0.05, rel=0.05)


def test_someone_else_s_planner_with_mujoco_s_roll_outs_pushes_the_box_under_our_servo(tmp_path):
    pytest.importorskip("mujoco", reason="the package mujoco could not be had")
    planner = example("--clock", "lockstep", program="mujoco_planner/planner.py")
    report, _ = run(ROOT / "examples/mujoco_planner/push.yaml", "planner", tmp_path / "out")
    ends(planner)
    assert report["result"] == "passed" and report["clients"][0]["problems"] == []


def soon(reader, condition):
    """The first sample of which it holds, or None."""
    end = time.monotonic() + PATIENCE
    for sample in reader.samples(PATIENCE):
        if condition(sample):
            return sample
        if time.monotonic() > end:
            return None
    return None


def test_the_page_s_mover_turns_a_joint_and_a_person_leads_the_arm(tmp_path):
    page = (ROOT / "docs/clients.md").read_text()
    mine = textwrap.dedent(re.search(r"^    import numpy as np\n(?:    .*\n|\n)*", page, re.MULTILINE).group())
    for said, instead in [("domain=0", f"domain={DOMAIN}"), ('clock="realtime"', 'clock="lockstep"')]:
        assert mine.count(said) == 1
        mine = mine.replace(said, instead)
    with Client(DOMAIN) as robot:
        states = robot.reader("robot/state", depth=2000)
        mover = subprocess.Popen([sys.executable, "-c", mine])
        c3rt("up", "circle_slow", "--without", "impedance", "--clock", "lockstep", "--domain", DOMAIN, "--out", tmp_path / "out")
        try:
            # from the scenario's initial pose, where joint 7 is 0
            state = soon(states, lambda state: state.mode.name == "ROBOT_IDLE" and state.q_rad[6] > 0.1)
            assert state.q_rad[6] == pytest.approx(0.2, abs=2e-3) and state.errors == 0
            assert robot.guide(axes=("y",), timeout=PATIENCE).text == "the arm is led by the hand"
            y = robot.newest("robot/state", PATIENCE).p_WE_m[1]
            robot.push((0.0, 15.0, 0.0), 1.0, timeout=PATIENCE)
            assert soon(states, lambda state: state.p_WE_m[1] > y + 0.02)
            robot.release(timeout=PATIENCE)
            assert robot.thresholds(Thresholds(40.0, 40.0), timeout=PATIENCE).text == "thresholds set"
        finally:
            c3rt("down", "--domain", DOMAIN)
            assert mover.wait(PATIENCE) == 0


def test_the_page_s_planner_is_one_and_what_it_does_wrong_is_named(tmp_path):
    page = (ROOT / "docs/clients.md").read_text()
    mine = textwrap.dedent(re.search(r"^    from c3rt.client import Knot, Planner\n(?:    .*\n|\n)*", page, re.MULTILINE).group())
    for said, instead in [("50.0,", "2.0,"), ("domain=0", f"domain={DOMAIN}"), ('clock="realtime"', 'clock="lockstep"')]:
        assert mine.count(said) == 1
        mine = mine.replace(said, instead)
    planner = subprocess.Popen([sys.executable, "-c", mine])
    report, said = run("circle_slow", "planner", tmp_path / "out", "--duration", "2", status=1)
    assert planner.wait(PATIENCE) == 0
    problems = report["clients"][0]["problems"]
    assert len(problems) == 1 and re.match(r"rate: \d gaps of more than 0.2 s \(impedance.limits.plan_timeout_s\)", problems[0])
    assert problems[0] in said


def test_the_page_s_client_reads_commands_and_ends_and_a_wrong_clock_is_named(tmp_path):
    c3rt("up", "circle_slow", "--clock", "lockstep", "--domain", DOMAIN, "--out", tmp_path / "out")
    try:
        text = (ROOT / "docs/clients/client.py").read_text()
        assert len([line for line in text.splitlines() if line and not line.startswith('"""')]) <= 10
        script = tmp_path / "client.py"
        script.write_text(text.replace("Client()", f"Client({DOMAIN})"))
        client = subprocess.Popen([sys.executable, "-u", str(script)], stdout=subprocess.PIPE, text=True)
        lines = [client.stdout.readline() for _ in range(20)]
        client.terminate()
        client.communicate(timeout=PATIENCE)
        assert "circle" in lines[1], lines
        numbers = [int(line.split()[0]) for line in lines[2:]]
        assert numbers == sorted(numbers) and len(set(numbers)) == len(numbers)

        planner = example("--clock", "realtime")
        words, _ = planner.communicate(timeout=PATIENCE)
        assert (planner.returncode, words) == (2, 'planner.py: error: the run is in lockstep, this planner in realtime: '
                                                  'clock="lockstep", --clock lockstep\n')

        with Client(DOMAIN) as robot:
            assert set(robot.status(timeout=PATIENCE)) == {"plant", "impedance", "planner", "vision"}
            with pytest.raises(Refused, match="^planner: refused: circle: radius_m: expected a number"):
                robot.target("circle", center_m=[0.55, 0.0], lead_rad=0.3, timeout=PATIENCE)
            assert [reply.process for reply in robot.stop(timeout=PATIENCE)] == ["plant", "impedance", "planner"]
            assert robot.newest(RobotState).mode.name in ("ROBOT_USER_STOPPED", "ROBOT_REFLEX")
            assert len(robot.recover(timeout=PATIENCE)) == 3
            assert robot.fault("plant", "push-object", value=(0.001, 0, 0), timeout=PATIENCE).process == "plant"
            with pytest.raises(Refused, match="^vision: "):
                robot.fault("vision", "push-object", value=(0.001, 0, 0), timeout=PATIENCE)
    finally:
        c3rt("down", "--domain", DOMAIN)


def test_ctrl_c_ends_a_planner_that_waits_without_a_word():
    for number, clock in ((signal.SIGINT, "lockstep"), (signal.SIGTERM, "realtime")):
        planner = example("--clock", clock)
        with Client(DOMAIN) as client:
            assert any("planner" in client.status(timeout=0.3) for _ in range(100))
        planner.send_signal(number)
        words, _ = planner.communicate(timeout=PATIENCE)
        assert (planner.returncode, words) == (0, "")
