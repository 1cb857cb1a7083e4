"""c3rt.envs: scenarios as environments of gymnasium."""

import os
import pathlib
import re
import subprocess
import sys

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium", reason="the package gymnasium is the extra [gym]")
from gymnasium.utils.env_checker import check_env  # noqa: E402

import c3rt.envs  # noqa: E402
from c3rt.envs import ScenarioEnv  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
SHORT = {"task.duration_s": 1}
# the T lies where it is to lie
AT_GOAL = {"plant.objects.0.start_spread_xy_m": [0, 0], "plant.objects.0.yaw_spread_rad": 0}


def test_the_library_alone_imports_no_gymnasium():
    words = "import sys, c3rt; sys.exit('gymnasium' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", words]).returncode == 0


@pytest.mark.filterwarnings("ignore:.*A Box observation space m.*infinity")
@pytest.mark.parametrize("name", ["c3rt/PushT-v0", "c3rt/RollBall-v0"])
def test_an_environment_keeps_gymnasium_s_rules(name):
    env = gymnasium.make(name, render_mode="rgb_array")
    check_env(env.unwrapped)


def actions(count):
    return np.random.default_rng(1).uniform(-1, 1, (count, 3))


def course(env, seed):
    observations = [env.reset(seed=seed)[0]]
    rewards = []
    for action in actions(30):
        observation, reward, *_ = env.step(action)
        observations.append(observation)
        rewards.append(reward)
    return np.array([np.concatenate([part.ravel() for part in seen.values()]) for seen in observations]), rewards


def test_the_same_seed_and_actions_give_the_same_observations_and_another_seed_others():
    env = ScenarioEnv("push_t")
    first, rewards = course(env, 3)
    other, _ = course(env, 4)
    again, same = course(env, 3)
    anew, _ = course(ScenarioEnv("push_t"), 3)
    assert (first == again).all() and (first == anew).all() and rewards == same
    assert (first[0] != other[0]).any()


def test_without_a_seed_each_episode_begins_elsewhere_and_a_seed_repeats_them_all():
    env = ScenarioEnv("push_t")
    starts = [env.reset(seed=seed)[0]["objects"] for seed in (1, None, None, 1, None, None)]
    assert (starts[1] != starts[2]).any()
    for first, second in zip(starts[:3], starts[3:]):
        assert (first == second).all()
    assert (env.reset(seed=2**64 + 1)[0]["objects"] == starts[0]).all()  # a run's seed has 64 bits


@pytest.mark.skipif("C3RT_PROGRAM" not in os.environ, reason="C3RT_PROGRAM names no c3rt that could run")
def test_an_episode_begins_as_a_run_of_the_same_seed(tmp_path):
    log = pytest.importorskip("c3rt.log")
    subprocess.run([os.environ["C3RT_PROGRAM"], "run", "push_t", "--in-process", "--seed", "5", "--duration", "0.1", "--no-pictures",
                    "--out", tmp_path / "out"], capture_output=True, check=False)
    scene = log.read(tmp_path / "out/run.mcap", topics=["sim/scene"])["sim/scene"].iloc[0]
    observation, _ = ScenarioEnv("push_t").reset(seed=5)
    np.testing.assert_array_equal(observation["objects"][0, :3], [scene[f"objects_0_p_WB_m_{i}"] for i in range(3)])
    np.testing.assert_array_equal(observation["objects"][0, 3:7], [scene[f"objects_0_q_WB_{i}"] for i in range(4)])
    np.testing.assert_array_equal(observation["effector"][:3], [scene[f"p_WE_m_{i}"] for i in range(3)])


def test_the_end_effector_goes_where_the_action_says_and_no_farther_than_the_workspace():
    env = ScenarioEnv("push_t", rate_hz=10, speed_m_per_s=0.2)
    observation, _ = env.reset(seed=1)
    start = observation["effector"][:3]
    for _ in range(10):
        observation, *_ = env.step([0, 0.5, 0.5])
    moved = observation["effector"][:3] - start
    np.testing.assert_allclose(moved, [0, 0.1, 0.1], atol=0.01)
    np.testing.assert_allclose(observation["effector"][3:6], [0, 0.1, 0.1], atol=0.02)
    for _ in range(30):
        observation, *_ = env.step([0, 0, 1])
    assert observation["effector"][8] == 0.4  # impedance.limits.workspace_max_m


def test_a_t_that_stays_at_its_goal_ends_the_episode_with_success():
    env = ScenarioEnv("push_t", settings=AT_GOAL, rate_hz=10)
    observation, info = env.reset(seed=1)
    assert observation["targets"][0] == pytest.approx([0.55, 0, 0], abs=1e-3)
    gained = 0.0
    for count in range(1, 21):
        _, reward, terminated, truncated, info = env.step([0, 0, 0])
        gained += reward
        if terminated:
            break
    assert info["is_success"] and not truncated and info["progress"] == 1
    assert count in (10, 11)  # task.hold_s is 1 s
    assert 0.99 < gained <= 1.0


def test_the_reward_is_the_error_of_the_pose():
    env = ScenarioEnv("push_t")
    env.reset(seed=2)
    observation, reward, *_ = env.step([0, 0, 0])
    x, y = observation["objects"][0, :2]
    w, _, _, z = observation["objects"][0, 3:7]
    turn = abs(2 * np.arctan2(z, w))
    turn = min(turn, 2 * np.pi - turn)
    assert reward == pytest.approx(-0.05 * (np.hypot(x - 0.55, y) + 0.1 * turn), rel=1e-3)
    assert abs(observation["targets"][0, 2]) == pytest.approx(turn, rel=1e-3)


def test_an_episode_is_cut_at_the_task_s_duration():
    env = ScenarioEnv("push_t", settings=SHORT)
    env.reset(seed=1)
    ends = [env.step([0, 0, 0])[2:4] for _ in range(20)]
    assert ends == [(False, False)] * 19 + [(False, True)]


def test_a_ball_that_is_pushed_out_of_reach_ends_the_episode():
    env = ScenarioEnv("circle_slow", settings={"plant.objects.0.position_m": [0.55, 0.31]})
    env.reset(seed=1)
    _, _, terminated, truncated, info = env.step([0, 0, 0])
    assert terminated and not truncated and info["out_of_reach"] and not info["is_success"]


def test_what_stops_the_robot_ends_the_episode_with_its_name(tmp_path):
    timid = (ROOT / "config/robots/panda.yaml").read_text()
    assert timid.count("velocity_max_m_per_s: 1.7") == 1
    (tmp_path / "timid.yaml").write_text(timid.replace("velocity_max_m_per_s: 1.7", "velocity_max_m_per_s: 0.1"))
    env = ScenarioEnv("push_t", settings={"robot": tmp_path / "timid.yaml"})
    env.reset(seed=1)
    for _ in range(20):
        *_, terminated, _, info = env.step([0, 1, 0])
        if terminated:
            break
    assert terminated and re.match(r"cartesian_velocity_violation \(0.1\d* m/s, limit 0.1\)", info["stopped"]), info


def test_the_picture_shows_the_object_from_above():
    env = gymnasium.make("c3rt/PushT-v0", render_mode="rgb_array").unwrapped
    observation, _ = env.reset(seed=1)
    picture = env.render()
    assert picture.shape == (128, 192, 3) and picture.dtype == np.uint8
    rows, columns = np.nonzero((picture.astype(int)[:, :, 0] - picture[:, :, 2]) > 100)  # the T is orange
    centre = 0.75 - (rows.mean() + 0.5) / 320, 0.3 - (columns.mean() + 0.5) / 320
    np.testing.assert_allclose(centre, observation["objects"][0, :2], atol=0.02)
    assert ScenarioEnv("push_t").render() is None


@pytest.mark.parametrize("call, error, message", [
    (lambda: ScenarioEnv("moon"), ValueError, '^unknown scenario "moon"; known: '),
    (lambda: ScenarioEnv("push_t", settings={"planner.rate_hz": -1}), ValueError, "planner.rate_hz: expected"),
    (lambda: ScenarioEnv("push_t", rate_hz=1), ValueError, "^rate_hz: expected a number from 5 to 1000, got 1"),
    (lambda: ScenarioEnv("push_t", speed_m_per_s=0), ValueError, "^speed_m_per_s: expected a number above 0, at most 1, got 0"),
    (lambda: ScenarioEnv("push_t", render_mode="human"), ValueError, "^render_mode: expected rgb_array or None, got 'human'"),
    (lambda: ScenarioEnv("push_t").step([0, 0, 0]), gymnasium.error.ResetNeeded, "before reset"),
    (lambda: stepped([0, 0]), ValueError, r"^action: expected 3 finite numbers, got \[0, 0\]"),
    (lambda: stepped([0, 0, np.nan]), ValueError, "^action: expected 3 finite numbers"),
])
def test_what_is_wrong_is_named_with_what_was_expected(call, error, message):
    with pytest.raises(error, match=message):
        call()


def stepped(action):
    env = ScenarioEnv("push_t")
    env.reset(seed=1)
    env.step(action)
