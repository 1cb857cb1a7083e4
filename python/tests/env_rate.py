"""How many steps c3rt.envs makes, with random actions.

    python python/tests/env_rate.py
"""

import time

import gymnasium

import c3rt.envs  # noqa: F401: registers them

STEPS = 400
for name in ("c3rt/PushT-v0", "c3rt/RollBall-v0"):
    env = gymnasium.make(name)
    env.reset(seed=1)
    env.action_space.seed(1)
    wall, processor = time.perf_counter(), time.process_time()
    for _ in range(STEPS):
        if any(env.step(env.action_space.sample())[2:4]):
            env.reset()
    print(f"{name}: {STEPS / (time.perf_counter() - wall):.0f} steps/s, {STEPS / (time.process_time() - processor):.0f} in a second of the processor")
