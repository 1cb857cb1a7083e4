"""The process: samples of c3rt to ROS 2's topics, goals of ROS 2 to the planner."""

from __future__ import annotations

import time
from typing import Any, Callable, Dict, List, Tuple, Type

from cyclonedds.core import DDSException
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from c3rt.client import Client, NoAnswer, Refused

from . import convert
from .messages import Clock, JointState, Marker, MarkerArray, PoseStamped, String, TFMessage, type_hash

SLOW_S = 0.1  # markers
GOAL_TIMEOUT_S = 5.0
POSITION_M, ANGLE_RAD, HOLD_S = 0.02, 0.1, 1.0  # when a goal counts as reached
SAME_CLOCK_NS = 2_000_000_000  # a state that is older, or lies ahead, is of another clock


def _qos(message: Type[Any], depth: int) -> Qos:
    """ROS 2's default: reliable, volatile, keep last; with the type's hash, and in the representation that it writes."""
    return Qos(Policy.Reliability.Reliable(duration(milliseconds=100)), Policy.Durability.Volatile,
               Policy.History.KeepLast(depth), Policy.DataRepresentation(True, False),
               Policy.Userdata(f"typehash={type_hash(message)};".encode()))


class Ros:
    """A participant among ROS 2's, and its topics by the names that ROS 2's programs show."""

    def __init__(self, domain: int) -> None:
        try:
            self._participant = DomainParticipant(domain)
        except DDSException as error:
            raise ConnectionError(f"ROS domain {domain} cannot be joined: {error}") from error
        self._writers: Dict[str, DataWriter] = {}

    def _topic(self, name: str, message: Type[Any]) -> Topic:
        return Topic(self._participant, "rt/" + name, message)

    def write(self, name: str, message: Any, depth: int = 10) -> None:
        if name not in self._writers:
            kind = type(message)
            self._writers[name] = DataWriter(self._participant, self._topic(name, kind), _qos(kind, depth))
        try:
            self._writers[name].write(message)
        except DDSException:
            pass  # a reader that does not take for longer than the quality allows loses it

    def reader(self, name: str, message: Type[Any]) -> DataReader:
        return DataReader(self._participant, self._topic(name, message), _qos(message, 10))


class Border:
    """@param scene as `c3rt ros` writes it: the objects' shapes"""

    def __init__(self, client: Client, ros: Ros, scene: Dict[str, Any], frame: str, rate_hz: float) -> None:
        self._client, self._ros, self._frame, self._period = client, ros, frame, 1.0 / rate_hz
        self._states = client.reader("robot/state")
        self._estimates = client.reader("object/estimate", 64)
        self._plans = client.reader("plan")
        self._debugs = client.reader("planner/debug")
        self._goals = ros.reader("goal_pose", PoseStamped)
        self._objects: Dict[int, Any] = {}
        shapes = [each["shape"] for each in scene["objects"]]
        self._looks = [convert.Looks(shape) for shape in shapes]
        self._rolls = bool(shapes) and shapes[0]["kind"] == "sphere"  # how it is turned is nobody's goal
        self._newest: Dict[str, Any] = {}
        self._markers_due = 0.0
        self._simulated = False

    def run(self, ended: Callable[[], bool]) -> None:
        due = time.monotonic()
        while not ended():
            left = due - time.monotonic()
            if left > 0:
                time.sleep(min(left, 0.05))
                continue
            due = max(due + self._period, time.monotonic() - self._period)
            self.step()

    def step(self) -> None:
        states = self._states.take()
        self._take_objects()
        for name, reader in (("plan", self._plans), ("debug", self._debugs)):
            taken = reader.take()
            if taken:
                self._newest[name] = taken[-1]
        if states:
            self._tell(states[-1])
        for message in self._goals.take(16):
            if isinstance(message, PoseStamped):
                self._ros.write("c3rt/goal_reply", String(self._take_goal(message)))

    def _take_objects(self) -> None:
        for estimate in self._estimates.take():
            self._objects[estimate.object_index] = estimate
            if estimate.valid:
                self._ros.write(f"c3rt/object_{estimate.object_index}/pose", convert.pose(estimate, self._header(estimate)))

    def _tell(self, state: Any) -> None:
        header = self._header(state)
        if self._simulated:
            self._ros.write("clock", Clock(header.stamp))
        self._ros.write("joint_states", convert.joint_state(state, header))
        objects = [self._objects[index] for index in sorted(self._objects)]
        self._ros.write("tf", convert.transforms(state, objects, header), 100)
        now = time.monotonic()
        if now < self._markers_due:
            return
        self._markers_due = now + SLOW_S
        markers: List[Marker] = []
        for estimate in objects:
            if estimate.valid and estimate.object_index < len(self._looks):
                markers += self._looks[estimate.object_index].markers(estimate, header)
        if "plan" in self._newest:
            markers.append(convert.plan_marker(self._newest["plan"], state, header))
        if "debug" in self._newest:
            markers.append(convert.target_marker(self._newest["debug"], header))
        self._ros.write("c3rt/markers", MarkerArray(markers))

    def _header(self, sample: Any) -> Any:
        """The instant by ROS 2's clock: this machine's where the sample's times are of its monotonic one, else simulated."""
        stamp_ns = sample.header.time_ns
        offset_ns = time.time_ns() - time.monotonic_ns()
        self._simulated = abs(time.monotonic_ns() - stamp_ns) > SAME_CLOCK_NS
        return convert.Header(convert.time_of(stamp_ns if self._simulated else stamp_ns + offset_ns), self._frame)

    def _take_goal(self, message: PoseStamped) -> str:
        try:
            parameters = convert.goal(message, (self._frame, "world"))
            if self._rolls:
                del parameters["yaws_rad"]
            else:
                parameters["angle_tolerance_rad"] = ANGLE_RAD
            reply = self._client.target("pose", GOAL_TIMEOUT_S, position_tolerance_m=POSITION_M, hold_s=HOLD_S, **parameters)
            return f"accepted: {reply.text}"
        except (convert.GoalError, Refused, NoAnswer) as error:
            return f"refused: {error}"


def names_of(objects: int) -> Tuple[str, ...]:
    """The topics, for a person."""
    return ("joint_states", "tf", "c3rt/markers", *(f"c3rt/object_{i}/pose" for i in range(objects)), "goal_pose (read)",
            "c3rt/goal_reply")
