"""A model-predictive planner as others write it, under c3rt's servo and safety: predictive sampling with roll-outs of MuJoCo
(pip install mujoco), which knows nothing of c3rt's models and solvers. It pushes a box to a place.

    python examples/mujoco_planner/planner.py --clock lockstep &
    c3rt run examples/mujoco_planner/push.yaml --without planner --clock lockstep
"""
import os
import pathlib

import numpy as np

os.environ.setdefault("MUJOCO_GL", "disable")  # nothing is drawn
import mujoco

from c3rt.client import Knot, Planner

GOAL = np.array([0.55, 0.08])
HEIGHT, ABOVE = 0.006, 0.12  # of the end effector beside the box and on its way [m]
BEHIND = 0.085  # of the box's centre, where a push begins [m]
STEPS, STEP_S = 6, 0.1  # of a roll-out: so many velocities, each for so long
SAMPLES, SPREAD, FASTEST = 24, 0.06, 0.15  # roll-outs a period; of their velocities [m/s]


class Sampling(Planner):
    """Pushes a box with MuJoCo's model of it: predictive sampling."""

    rate_hz, phase, valid_for_s = 20.0, "approach", 0.15

    def __init__(self):
        self.model = mujoco.MjModel.from_xml_path(str(pathlib.Path(__file__).with_name("model.xml")))
        self.data = mujoco.MjData(self.model)
        self.random = np.random.default_rng(1)
        self.best = np.zeros((STEPS, 2))

    def plan(self, now):
        if 0 not in now.objects:
            return None
        box, tip = now.objects[0], now.effector
        off = GOAL - box.p[:2]
        away = off / max(np.linalg.norm(off), 1e-6)
        if self.phase == "approach":
            return self.approach(tip, [*(box.p[:2] - BEHIND * away), HEIGHT])
        if np.linalg.norm(off) < 0.004:
            return Knot(tip.p)
        shifted = np.vstack([self.best[1:], self.best[-1:]])
        tried = shifted + SPREAD * self.random.normal(size=(SAMPLES, 1, 2))
        tried = np.clip(np.concatenate([[shifted], [FASTEST * np.tile(away, (STEPS, 1))], tried]), -FASTEST, FASTEST)
        self.best = tried[np.argmin([self.cost(velocities, box, tip) for velocities in tried])]
        way = np.vstack([tip.p[:2], tip.p[:2] + STEP_S * np.cumsum(self.best, axis=0)])
        speeds = np.vstack([self.best[:1], self.best])
        return [Knot([*p, HEIGHT], [*v, 0.0], after=STEP_S * i) for i, (p, v) in enumerate(zip(way, speeds))]

    def approach(self, tip, place):
        """Up, behind the box, and down."""
        beside = np.linalg.norm(tip.p[:2] - place[:2])
        if beside < 0.005 and abs(tip.p[2] - HEIGHT) < 0.005:
            self.phase = "push"
        to = np.array(place) if beside < 0.005 else np.array([*(place[:2] if tip.p[2] > ABOVE - 0.03 else tip.p[:2]), ABOVE])
        way = to - tip.p
        pace = way / max(np.linalg.norm(way), 0.02)
        return Knot(tip.p + 0.02 * pace, 0.2 * pace)

    def cost(self, velocities, box, tip):
        """Of a roll-out from what is now: how far the box is from its goal, and the end effector from behind it."""
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[:], self.data.qvel[:] = [*box.p, *box.q, *tip.p], [*box.v, *np.zeros(3), *tip.v]
        to, total = tip.p[:2].copy(), 0.0
        for velocity in velocities:
            to = to + STEP_S * velocity
            self.data.ctrl[:] = [*to, HEIGHT]
            mujoco.mj_step(self.model, self.data, round(STEP_S / self.model.opt.timestep))
            off = GOAL - self.data.qpos[:2]
            behind = self.data.qpos[:2] - BEHIND * off / max(np.linalg.norm(off), 1e-6)
            total += np.linalg.norm(off) + 0.2 * np.linalg.norm(self.data.qpos[7:9] - behind) + 0.01 * np.linalg.norm(velocity)
        return total


if __name__ == "__main__":
    Sampling().main()
