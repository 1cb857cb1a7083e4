"""Environments of gymnasium: a scenario's arm, table and objects in simulated time, the end effector moved by the action.

    import gymnasium
    import c3rt.envs                              # registers c3rt/PushT-v0 and c3rt/RollBall-v0

    env = gymnasium.make("c3rt/PushT-v0")
    observation, info = env.reset(seed=3)         # begins as c3rt run push_t --seed 3

The action moves what the impedance controller follows, which with its limits and the robot's own guard stands between the
action and the arm as in every run; vision and planner are left out, and the observation is the simulation's truth. Needs
gymnasium: pip install './python[gym]'.
"""

from __future__ import annotations

import os
from typing import Any, Dict, Mapping, Optional, Tuple, Union

import numpy as np
import numpy.typing as npt

try:
    import gymnasium
    from gymnasium import spaces
except ImportError as error:
    raise ImportError("c3rt.envs needs the package gymnasium: pip install './python[gym]' (docs/clients.md)") from error

from ._core import Emulator
from ._run import _yaml

Array = npt.NDArray[np.float64]
Observation = Dict[str, Array]

RADIAN_M = 0.1  # so many metres of error is a radian
LEASH_M = 0.03  # no farther ahead of the arm is where it is asked to be
PIXELS_PER_METRE = 320
PIXELS_OF_A_TARGET = 3


class ScenarioEnv(gymnasium.Env[Observation, Array]):
    """Any scenario of one arm, by its name or file.

    settings: {"task.duration_s": 20} overrides keys of the scenario; rate_hz: actions a second; speed_m_per_s: of the end
    effector along each axis with the action 1.

    Action: Box(-1, 1, (3,)), the velocity that the end effector is asked for, in parts of speed_m_per_s. Where it is asked to be
    stays within the scenario's workspace and 3 cm of where it is.
    Observation, in W and SI units: "effector" (9,): position, velocity, where it is asked to be; "objects" (n, 13): position of
    the centre of mass, orientation w x y z, velocity, angular velocity; "targets" (n, 3): where the task wants the object on the
    table, and the turn about z that is to go.
    Reward: what the task has gained (1 for a goal, a round, an object that has arrived; rounds count in parts) minus the mean
    error of the objects [m] times the period [s]; a radian of error counts 0.1 m.
    Terminated: when a run would end by itself (info["is_success"]), when the robot has stopped (info["stopped"] says why), or
    when an object is out of reach (info["out_of_reach"]). Truncated: at the scenario's task.duration_s.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 20}

    def __init__(self, scenario: Union[str, "os.PathLike[str]"] = "push_t", *, settings: Optional[Mapping[str, Any]] = None,
                 rate_hz: float = 20.0, speed_m_per_s: float = 0.3, render_mode: Optional[str] = None):
        if render_mode is not None and render_mode not in self.metadata["render_modes"]:
            raise ValueError(f"render_mode: expected rgb_array or None, got {render_mode!r}")
        overrides = [f"{key}={_yaml(value)}" for key, value in (settings or {}).items()]
        self._emulator = Emulator(os.fspath(scenario), overrides)
        lowest = 1.0 / self._emulator.longest_s
        if not lowest <= rate_hz <= 1000.0:
            raise ValueError(f"rate_hz: expected a number from {lowest:g} to 1000, got {rate_hz!r}")
        if not 0.0 < speed_m_per_s <= 1.0:
            raise ValueError(f"speed_m_per_s: expected a number above 0, at most 1, got {speed_m_per_s!r}")
        self.render_mode = render_mode
        self.metadata = {**self.metadata, "render_fps": round(rate_hz)}
        self._period, self._speed = round(1e3 / rate_hz) * 1e-3, speed_m_per_s
        self._least, self._most = self._emulator.workspace
        self._asked: Optional[Array] = None
        count = len(self._emulator.objects)

        def anything(*shape: int) -> spaces.Box:
            return spaces.Box(-np.inf, np.inf, shape, np.float64)

        self.action_space = spaces.Box(-1.0, 1.0, (3,), np.float64)
        self.observation_space = spaces.Dict(  # type: ignore[assignment]
            {"effector": anything(9), "objects": anything(count, 13), "targets": anything(count, 3)})

    def reset(self, *, seed: Optional[int] = None, options: Optional[Dict[str, Any]] = None) -> Tuple[Observation, Dict[str, Any]]:
        """Begins as `c3rt run --seed SEED`; without a seed, as with one that is drawn."""
        super().reset(seed=seed)
        self._emulator.begin(int(self.np_random.integers(1, 2**31)) if seed is None else int(seed) % 2**64)
        self._asked = self._emulator.effector[:3]
        return self._observation(), self._info()

    def step(self, action: Array) -> Tuple[Observation, float, bool, bool, Dict[str, Any]]:
        if self._asked is None:
            raise gymnasium.error.ResetNeeded("step() was called before reset()")
        wanted = np.asarray(action, dtype=float)
        if wanted.shape != (3,) or not np.isfinite(wanted).all():
            raise ValueError(f"action: expected 3 finite numbers, got {action!r}")
        emulator, before = self._emulator, self._emulator.progress
        at = emulator.effector[:3]
        lead = self._asked + np.clip(wanted, -1.0, 1.0) * self._speed * self._period - at
        lead *= min(1.0, LEASH_M / max(np.linalg.norm(lead), 1e-9))
        end = np.clip(at + lead, self._least, self._most)
        emulator.move(self._asked, end, self._period)
        self._asked = end
        info = self._info()
        reward = emulator.progress - before - self._period * float(np.mean(info["errors_m"] + RADIAN_M * info["errors_rad"]))
        terminated = bool(info["is_success"] or info["stopped"] or info["out_of_reach"])
        truncated = not terminated and emulator.elapsed_s >= emulator.duration_s - 1e-9
        return self._observation(), float(reward), terminated, truncated, info

    def render(self) -> Optional[npt.NDArray[np.uint8]]:  # type: ignore[override]
        """The table from above, as the robot sees it: x to the top, y to the left. White: where the task wants the objects."""
        if self.render_mode is None:
            return None
        least, most = self._emulator.reach
        height, width = (int(pixels) for pixels in np.round((most - least) * PIXELS_PER_METRE))
        picture = self._emulator.picture(width, height)
        for x, y in self._emulator.targets[:, :2]:
            row, column = ((most - (x, y)) * PIXELS_PER_METRE).astype(int)
            picture[max(row - PIXELS_OF_A_TARGET, 0) : row + PIXELS_OF_A_TARGET,
                    max(column - PIXELS_OF_A_TARGET, 0) : column + PIXELS_OF_A_TARGET] = 255
        return picture

    def _observation(self) -> Observation:
        emulator = self._emulator
        return {"effector": np.concatenate([emulator.effector, self._asked]),  # type: ignore[arg-type]
                "objects": emulator.objects, "targets": np.ascontiguousarray(emulator.targets[:, :3])}

    def _info(self) -> Dict[str, Any]:
        emulator = self._emulator
        return {"time_s": emulator.elapsed_s, "progress": emulator.progress, "is_success": emulator.done,
                "errors_m": emulator.targets[:, 3], "errors_rad": emulator.targets[:, 4], "stopped": emulator.stopped,
                "out_of_reach": emulator.out_of_reach >= 0}


gymnasium.register("c3rt/PushT-v0", entry_point="c3rt.envs:ScenarioEnv", kwargs={"scenario": "push_t"})
gymnasium.register("c3rt/RollBall-v0", entry_point="c3rt.envs:ScenarioEnv", kwargs={"scenario": "circle_slow"})
