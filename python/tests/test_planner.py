"""c3rt.SamplingPlanner: the planner of the strategy sampling, called with a scene and a goal."""

import os
import subprocess

import numpy as np
import pytest

import c3rt

PROGRAM = os.environ.get("C3RT_PROGRAM")
SCENARIO = "push_t"
PUBLISHED_AFTER_NS = 7_500_000  # planner.publish_delay_s


def lying(x, y, yaw=0.0):
    """A row of objects: the T on the table, at rest."""
    return [[x, y, 0.0, np.cos(yaw / 2), 0, 0, np.sin(yaw / 2), 0, 0, 0, 0, 0, 0]]


def above(planner):
    """The end effector over the middle of the table, at rest."""
    return [0.55, 0.0, 0.25, 0, 0, 0]


def test_the_place_that_it_chooses_is_the_cheapest_of_those_that_it_weighed():
    planner = c3rt.SamplingPlanner(SCENARIO, seed=3)
    weighed, costs, gains = [], [], []
    for i in range(300):
        plan = planner.step(1.0 + i / planner.rate_hz, above(planner), lying(0.45, 0.15))
        weighed += plan.candidates.tolist()
        costs += plan.costs.tolist()
        gains += plan.gains.tolist()
        assert len(plan.candidates) == len(plan.costs) == len(plan.gains) == len(plan.candidate_objects)
        if plan.place is not None:
            break
        assert plan.phase == "approach" and plan.delta_t_c_s == 0
    assert plan.place is not None, plan.words
    assert len(costs) >= 4
    chosen = weighed.index(plan.place.tolist())
    assert costs[chosen] == min(costs) and gains[chosen] == max(gains) > 0
    assert np.isfinite(costs[chosen])
    # beside the T, not in it
    assert 0.02 < np.linalg.norm(plan.place[:2] - [0.45, 0.15]) < 0.25


def test_where_the_end_effector_is_at_its_place_it_pushes_with_c3():
    planner = c3rt.SamplingPlanner(SCENARIO, seed=3)
    objects = lying(0.45, 0.15)
    effector = np.array(above(planner), dtype=float)
    for i in range(2000):
        plan = planner.step(1.0 + i / planner.rate_hz, effector, objects)
        if plan.phase == "push":
            break
        effector[:3] = plan.p
        effector[3:] = 0
    assert plan.phase == "push", plan.words
    assert plan.status == "ok"
    assert plan.delta_t_c_s > 0 and np.abs(plan.x).max() > 0
    assert plan.x.shape[0] == plan.u.shape[0] == plan.lam.shape[0]
    np.testing.assert_allclose(np.linalg.norm(plan.q), 1)


def test_a_goal_is_taken_or_refused_with_the_reason():
    planner = c3rt.SamplingPlanner(SCENARIO)
    words = planner.target("pose", goals_m=[[0.5, 0.1]], yaws_rad=0.5, position_tolerance_m=0.01, angle_tolerance_rad=0.1, hold_s=1.0)
    assert "0.5" in words
    plan = planner.step(1.0, above(planner), lying(0.6, -0.1))
    np.testing.assert_allclose(plan.target[:2], [0.5, 0.1])
    with pytest.raises(ValueError, match="goals_m"):
        planner.target("pose", position_tolerance_m=0.01)
    with pytest.raises(ValueError, match="goal.*0.95"):
        planner.target("pose", goals_m=[[0.95, 0.1]], position_tolerance_m=0.01, hold_s=1.0)
    assert planner.target("hold") == "hold"
    plan = planner.step(1.0 + 1 / planner.rate_hz, above(planner), lying(0.6, -0.1))
    assert plan.phase == "hold" and plan.place is None and len(plan.candidates) == 0


def test_the_same_input_and_seed_give_the_same_bits_and_another_seed_others():
    def course(seed):
        planner = c3rt.SamplingPlanner(SCENARIO, seed=seed)
        plans = [planner.step(1.0 + i / planner.rate_hz, above(planner), lying(0.45, 0.15)) for i in range(10)]
        return np.concatenate([np.ravel(plan.candidates) for plan in plans])

    first = course(1)
    assert len(first) > 0 and (first == course(1)).all()
    assert not np.array_equal(first, course(2))


def test_what_cannot_be_is_named():
    with pytest.raises(ValueError, match="strategy sampling.*circle_slow"):
        c3rt.SamplingPlanner("circle_slow")
    planner = c3rt.SamplingPlanner(SCENARIO)
    with pytest.raises(ValueError, match=r"effector: expected the shape \(6,\), got \(3,\)"):
        planner.step(1.0, [0.5, 0, 0.2], lying(0.5, 0))
    with pytest.raises(ValueError, match=r"objects: expected the shape \(1, 13\)"):
        planner.step(1.0, above(planner), np.zeros((2, 13)))
    with pytest.raises(ValueError, match="quaternions"):
        planner.step(1.0, above(planner), np.zeros((1, 13)))
    assert planner.step(1.0, None, None).phase == "wait"


@pytest.mark.skipif(not PROGRAM, reason="C3RT_PROGRAM names no c3rt that could make a recording")
def test_a_run_s_planner_given_the_same_samples_has_planned_the_same_bits(tmp_path):
    log = pytest.importorskip("c3rt.log", exc_type=ImportError)
    subprocess.run([PROGRAM, "run", SCENARIO, "--in-process", "--seed", "5", "--duration", "4", "--no-pictures", "--out", tmp_path / "run"],
                   capture_output=True, check=False)
    recording = log.read(tmp_path / "run" / "run.mcap")
    state, estimate, command, plans, debug = (
        recording[topic] for topic in ("robot/state", "object/estimate", "robot/command", "plan", "planner/debug"))
    planner = c3rt.SamplingPlanner(SCENARIO, seed=5)

    def newest(frame, now):
        known = frame["time_ns"].searchsorted(now, side="right")
        return frame.iloc[known - 1] if known else None

    def vector(row, name, size):
        return [row[f"{name}_{i}"] for i in range(size)]

    phases = set()
    for (_, row), (_, why) in zip(plans.iterrows(), debug.iterrows()):
        now = row["time_ns"] - PUBLISHED_AFTER_NS
        at, seen, told = newest(state, now), newest(estimate, now), newest(command, now)
        objects = ages = valid = None
        if seen is not None:
            objects = [vector(seen, "p_WB_m", 3) + vector(seen, "q_WB", 4) + vector(seen, "v_WB_m_per_s", 3)
                       + vector(seen, "omega_rad_per_s", 3)]
            ages, valid = [(now - seen["exposure_ns"]) * 1e-9], [float(seen["valid"])]
        follows = told is not None and at["mode"] == "move" and told["mode"] == "track" and now - told["time_ns"] <= 100_000_000
        plan = planner.step(now * 1e-9, planner.effector(vector(at, "q_rad", 7), vector(at, "dq_rad_per_s", 7)), objects, ages, valid,
                            bool(follows))
        assert plan.phase == row["phase"], now
        phases.add(plan.phase)
        assert plan.p.tolist() == vector(row, "knots_0_p_WE_m", 3), now
        assert plan.v.tolist() == vector(row, "knots_0_v_WE_m_per_s", 3), now
        assert plan.force.tolist() == vector(row, "knots_0_force_E_n", 3), now
        assert plan.x.ravel().tolist() == list(why["states"][: plan.x.size]), now
        known = np.isfinite(plan.costs)
        assert known.sum() == why["candidate_count"], now
        assert plan.costs[known].tolist() == [why[f"candidates_{i}_cost"] for i in range(known.sum())], now
    assert len(plans) > 300
    assert {"approach", "push"} <= phases
