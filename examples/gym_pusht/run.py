"""Push-T of gym-pusht with c3rt's planner: in each step the scene goes to `c3rt plan` as a line of JSON, and its
answer says where the agent should be at the end of the step.

    python run.py --c3rt ../../build/release/bin/c3rt --seeds 0..99 --out table.csv
"""
import argparse
import csv
import json
import math
import os
import pathlib
import subprocess
import warnings

warnings.filterwarnings("ignore")
os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
import cv2
import gym_pusht  # registers the environment
import gymnasium
import numpy as np

SCENARIO = pathlib.Path(__file__).with_name("pusht.yaml")
# gym-pusht measures in pixels, from the field's corner; c3rt in metres, in its world W
METRES_PER_PIXEL = 1e-3
MIDDLE_PX, MIDDLE_M = np.array([256.0, 256.0]), np.array([0.55, 0.0])
HEIGHT_M = 0.0055  # of the plane in which everything happens
CENTRE_OF_MASS_PX = np.array([0.0, 45.0])  # of the T, in pymunk's frame of it
FIELD_PX = 512.0  # the action space


def metres(pixels):
    x, y = MIDDLE_M + METRES_PER_PIXEL * (np.asarray(pixels) - MIDDLE_PX)
    return [float(x), float(y), HEIGHT_M]


def pixels(metres_in_world):
    return MIDDLE_PX + (np.asarray(metres_in_world)[:2] - MIDDLE_M) / METRES_PER_PIXEL


def scene(time_s, info):
    """What c3rt plan wants to know: docs/clients.md."""
    x, y, angle = info["block_pose"]
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    velocity = METRES_PER_PIXEL * np.asarray(info["vel_agent"])
    return {
        "time_s": time_s,
        "end_effector": {"position_m": metres(info["pos_agent"]),
                         "velocity_m_per_s": [float(velocity[0]), float(velocity[1]), 0.0]},
        "objects": [{"position_m": metres(np.array([x, y]) + turn @ CENTRE_OF_MASS_PX),
                     "yaw_rad": math.remainder(float(angle), 2.0 * math.pi)}],
    }


class Planner:
    """One `c3rt plan`, which remembers what it was about: a new one for each episode."""

    def __init__(self, command, scenario, overrides):
        options = [word for override in overrides for word in ("--set", override)]
        self.process = subprocess.Popen([command, "plan", str(scenario), *options], text=True,
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    def __call__(self, scene_now):
        print(json.dumps(scene_now), file=self.process.stdin, flush=True)
        answer = self.process.stdout.readline()
        if not answer:
            raise SystemExit(f"c3rt plan has ended with status {self.process.wait()}")
        return json.loads(answer)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.stdin.close()
        self.process.wait()


class Agent:
    """The environment's agent: p'' = k_p (action - p) - k_v p' for one step of constant action. Where it is and how
    fast at the end is linear in the action, so the action for a place is known."""

    SPEED_WEIGHT_S = 0.03  # its speed at the end counts as little; without it the agent swings about its way

    def __init__(self, env):
        dt, k_p, k_v = env.dt, env.k_p, env.k_v
        one = np.array([[1.0 - dt * dt * k_p, dt * (1.0 - dt * k_v)], [-dt * k_p, 1.0 - dt * k_v]])
        self.free, self.forced = np.eye(2), np.zeros(2)
        for _ in range(int(1 / (dt * env.control_hz))):
            self.free = one @ self.free
            self.forced = one @ self.forced + k_p * np.array([dt * dt, dt])

    def action(self, info, position, velocity):
        weight = np.array([1.0, self.SPEED_WEIGHT_S**2])
        change = np.array([position, velocity]) - self.free @ np.array([info["pos_agent"], info["vel_agent"]])
        return np.clip((weight * self.forced) @ change / (weight @ self.forced**2), 0.0, FIELD_PX)


def run_episode(env, planner, seed, steps, frames=None):
    _, info = env.reset(seed=seed)
    agent = Agent(env.unwrapped)
    period_s = 1.0 / env.unwrapped.control_hz
    coverages, done = [], False
    while not done and len(coverages) < steps:
        if frames is not None:
            frames.append(env.render())
        plan = planner(scene(period_s * (len(coverages) + 1), info))
        velocity = np.asarray(plan["velocity_m_per_s"])[:2] / METRES_PER_PIXEL
        _, _, done, _, info = env.step(agent.action(info, pixels(plan["position_m"]), velocity))
        coverages.append(info["coverage"])
    if frames is not None:
        frames.append(env.render())
    return {"seed": seed, "success": int(done), "steps": len(coverages), "coverage": round(coverages[-1], 4)}


def picture(frames, count=5):
    """Some of them in a row, the first and the last among them."""
    chosen = [frames[round(i * (len(frames) - 1) / (count - 1))] for i in range(count)]
    return cv2.cvtColor(np.concatenate([cv2.resize(f, (320, 320), interpolation=cv2.INTER_AREA) for f in chosen], axis=1),
                        cv2.COLOR_RGB2BGR)


def summary(rows):
    steps = sorted(row["steps"] for row in rows if row["success"])
    line = f"coverage above 0.95 in {len(steps)} of {len(rows)} episodes"
    if steps:
        line += f", after {steps[len(steps) // 2]} steps (median), {steps[(len(steps) * 9) // 10]} (90 %), {steps[-1]} (most)"
    return line


def seeds_of(text):
    first, _, last = text.partition("..")
    return range(int(first), int(last or first) + 1)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--c3rt", default="c3rt", help="the command; default: that of the PATH")
    parser.add_argument("--scenario", default=SCENARIO)
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="overrides one key of the scenario")
    parser.add_argument("--seeds", type=seeds_of, default=seeds_of("0..99"), help="of the environment; default: 0..99")
    parser.add_argument("--steps", type=int, default=300, help="of an episode at most; default: the environment's 300")
    parser.add_argument("--out", help="file of the table (CSV)")
    parser.add_argument("--picture", help="file of a picture (PNG) of the first seed's episode")
    given = parser.parse_args()
    env = gymnasium.make("gym_pusht/PushT-v0", obs_type="state", render_mode="rgb_array", max_episode_steps=given.steps)
    rows = []
    for seed in given.seeds:
        frames = [] if given.picture and not rows else None
        with Planner(given.c3rt, given.scenario, given.set) as planner:
            rows.append(run_episode(env, planner, seed, given.steps, frames))
        print(*(f"{name} {value}" for name, value in rows[-1].items()), flush=True)
        if frames:
            cv2.imwrite(given.picture, picture(frames))
    print(summary(rows))
    if given.out:
        with open(given.out, "w", newline="") as file:
            table = csv.DictWriter(file, rows[0].keys())
            table.writeheader()
            table.writerows(rows)


if __name__ == "__main__":
    main()
