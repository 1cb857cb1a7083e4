"""Reads where the planner wants the end effector, and gives it another circle: pip install './python[dds]'."""
from c3rt.client import Client

with Client() as robot:  # domain 0 and profile loopback are those of c3rt up
    plan = robot.newest("plan")
    print(plan.phase, plan.knots[0].p_WE_m)
    print(robot.target("circle", center_m=[0.55, 0.0], radius_m=0.08, lead_rad=0.349).text)
    for state in robot.reader("robot/state", depth=100).samples(timeout=1.0):  # each, until none has come for a second
        print(state.header.seq, state.p_WE_m)
