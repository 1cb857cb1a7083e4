"""A client of a running service: read every topic, give tasks, or play the planner or the cameras.

    from c3rt.client import Client

    with Client() as robot:                       # domain 0, profile loopback
        print(robot.newest("plan").phase)         # the newest sample, waited for
        robot.target("circle", center_m=[0.55, 0.0], radius_m=0.08)

Needs the package cyclonedds: pip install './python[dds]'. The types are c3rt.v2's, generated from idl/c3rt.idl;
docs/clients.md has the topics and the rules of the bus. A Planner, an Estimator and a Mover of one's own are classes with one method.
"""

from ._bus import Reader
from ._client import Client, Reply, Thresholds
from ._errors import NoAnswer, Refused, WrongClock
from ._process import (
    CartesianPose,
    CartesianVelocities,
    Effector,
    Estimate,
    Estimator,
    JointPositions,
    JointVelocities,
    Knot,
    Mover,
    Object,
    Planner,
    Situation,
)

__all__ = [
    "CartesianPose",
    "CartesianVelocities",
    "Client",
    "Effector",
    "Estimate",
    "Estimator",
    "JointPositions",
    "JointVelocities",
    "Knot",
    "Mover",
    "NoAnswer",
    "Object",
    "Planner",
    "Reader",
    "Refused",
    "Reply",
    "Situation",
    "Thresholds",
    "WrongClock",
]
