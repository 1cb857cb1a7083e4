"""A client that reads and asks."""

from __future__ import annotations

import random
import time
from types import TracebackType
from typing import Any, Dict, Iterable, List, Mapping, NamedTuple, Optional, Sequence, Type, TypeVar, Union, overload

import c3rt.v2 as types

from ._bus import PROCESSES, SLICE_S, TOPICS, Bus, Reader, Writer, topic_of
from ._errors import NoAnswer, Refused

T = TypeVar("T")
Value = Union[bool, float, str, Sequence[Any]]

FAULTS = {"none": types.FaultKind.FAULT_NONE, "push-object": types.FaultKind.FAULT_PUSH_OBJECT,
          "drop-commands": types.FaultKind.FAULT_DROP_COMMANDS, "freeze-camera": types.FaultKind.FAULT_FREEZE_CAMERA,
          "lose-object": types.FaultKind.FAULT_LOSE_OBJECT, "stall": types.FaultKind.FAULT_STALL,
          "nan": types.FaultKind.FAULT_NAN}
AXES = ("x", "y", "z", "roll", "pitch", "yaw")
LONGEST_TEXT = 31
LONGEST_NAME = 63  # of a weight


class Reply(NamedTuple):
    """What a process has answered."""

    process: str
    text: str


def process_of(name: str) -> types.Process:
    if not isinstance(name, str):
        raise TypeError(f"process: expected one of {', '.join(PROCESSES[:4])}, got {name!r}")
    if name not in PROCESSES[:4]:
        raise ValueError(f"process: expected one of {', '.join(PROCESSES[:4])}, got {name!r}")
    return types.Process(PROCESSES.index(name))


def _numbers(name: str, value: Any) -> List[float]:
    """A list of lists one row after the other, a truth 0 or 1."""
    if isinstance(value, (bool, int, float)):
        return [float(value)]
    if isinstance(value, str) or not isinstance(value, Iterable):
        raise TypeError(f"{name}: expected numbers or lists of numbers, got {value!r}")
    return [number for entry in value for number in _numbers(name, entry)]


def _text(name: str, value: str, longest: int = LONGEST_TEXT) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{name}: expected a text, got {value!r}")
    if not 0 < len(value.encode()) <= longest:
        raise ValueError(f"{name}: expected a text of 1 to {longest} bytes, got {value!r}")
    return value


def target_sample(kind: str, parameters: Dict[str, Value], request_id: int = 0) -> types.TaskTarget:
    """task/target of a kind of task and its parameters, by the keys of a scenario's section `task`."""
    if len(parameters) > types.MAX_TARGET_PARAMETERS:
        raise ValueError(f"target: expected at most {types.MAX_TARGET_PARAMETERS} parameters, got {len(parameters)}")
    sample = types.TaskTarget(request_id=request_id, kind=_text("kind", kind), parameter_count=len(parameters))
    for place, (name, value) in zip(sample.parameters, parameters.items()):
        place.name = _text("parameter", name)
        if isinstance(value, str):
            place.word = _text(name, value)
            continue
        numbers = _numbers(name, value)
        if len(numbers) > types.MAX_TARGET_VALUES:
            raise ValueError(f"{name}: expected at most {types.MAX_TARGET_VALUES} numbers, got {len(numbers)}")
        place.value_count = len(numbers)
        place.values[: len(numbers)] = numbers
    return sample


def weights_sample(weights: Mapping[str, float], request_id: int = 0) -> types.PlannerWeights:
    """planner/weights of weights by their names."""
    if len(weights) > types.MAX_WEIGHTS:
        raise ValueError(f"weights: expected at most {types.MAX_WEIGHTS}, got {len(weights)}")
    sample = types.PlannerWeights(request_id=request_id, weight_count=len(weights))
    for place, (name, value) in zip(sample.weights, weights.items()):
        place.name = _text("weight", name, LONGEST_NAME)
        numbers = _numbers(name, value)
        if len(numbers) != 1:
            raise ValueError(f"{name}: expected a number, got {value!r}")
        place.value = numbers[0]
    return sample


def _numbers_of(name: str, value: Any, count: int) -> List[float]:
    """One for all, or so many."""
    numbers = _numbers(name, value)
    if len(numbers) not in (1, count):
        raise ValueError(f"{name}: expected 1 or {count} numbers, got {len(numbers)}")
    return numbers * count if len(numbers) == 1 else numbers


class Thresholds(NamedTuple):
    """From which torque or force on a contact is told, and from which on a collision stops the robot: one number for all, or one
    for each of seven joints, and along and about x, y, z of the end effector. A contact's that is not given is the collision's."""

    collision_torque: Any  # [N m]
    collision_force: Any  # [N, N m]
    contact_torque: Any = None
    contact_force: Any = None

    def sample(self) -> types.ContactThresholds:
        collision = _numbers_of("collision_force", self.collision_force, 6)
        contact = collision if self.contact_force is None else _numbers_of("contact_force", self.contact_force, 6)
        torque = _numbers_of("collision_torque", self.collision_torque, 7)
        contact_torque = torque if self.contact_torque is None else _numbers_of("contact_torque", self.contact_torque, 7)
        return types.ContactThresholds(contact_torque, torque, contact[:3], contact[3:], collision[:3], collision[3:])


class Client:
    """A participant of a service's bus: as a context manager, or with close().

    domain, profile: those of `c3rt up` (`c3rt status` tells them); profile is a name (loopback, lan) or a DDS profile's file.
    No environment variable is needed. Times of samples are of CLOCK_MONOTONIC (time.monotonic_ns()), in lockstep simulated.
    """

    def __init__(self, domain: int = 0, profile: str = "loopback"):
        self._bus = Bus(domain, profile)
        self._readers: Dict[str, Reader[Any]] = {}
        self._writers: Dict[str, Writer] = {}
        self._next_id = random.SystemRandom().randrange(1, 1 << 62)
        try:
            self._replies = self._own_reader("service/reply", 64)
            self._statuses = self._own_reader("service/status", 16)
        except BaseException:
            self._bus.close()
            raise
        self._status: Dict[str, types.ServiceStatus] = {}

    # ---- reading

    @overload
    def reader(self, topic: Type[T], depth: int = 1) -> Reader[T]: ...
    @overload
    def reader(self, topic: str, depth: int = 1) -> Reader[Any]: ...
    def reader(self, topic: Union[str, type], depth: int = 1) -> Reader[Any]:
        """A reader of its own, of a topic by its name or its type (c3rt.v2.Plan): keeps the newest `depth` samples until they
        are taken. depth=1: the latest value; more: a queue."""
        self._bus.require_open()
        return Reader(self._bus, topic_of(topic).name, depth)

    @overload
    def newest(self, topic: Type[T], timeout: float = 5.0) -> T: ...
    @overload
    def newest(self, topic: str, timeout: float = 5.0) -> Any: ...
    def newest(self, topic: Union[str, type], timeout: float = 5.0) -> Any:
        """The newest sample of a topic, waited for where none has come. @raises NoAnswer after timeout seconds"""
        name = topic_of(topic).name
        if name not in self._readers:
            self._readers[name] = self.reader(name)
        return self._readers[name].newest(timeout)

    def status(self, timeout: float = 2.0) -> Dict[str, types.ServiceStatus]:
        """What each process says of itself, by its name. Waits until all four have been heard, or for timeout seconds."""
        self._bus.require_open()
        end = time.monotonic() + timeout
        heard: Dict[str, types.ServiceStatus] = {}
        while True:
            for sample in self._statuses.take():
                heard[PROCESSES[sample.process.value]] = sample
            left = end - time.monotonic()
            if left <= 0.0 or all(name in heard for name in PROCESSES[:4]):
                self._status.update(heard)
                return heard
            self._statuses.sleep(left)

    # ---- asking

    def target(self, kind: str, timeout: float = 5.0, **parameters: Value) -> Reply:
        """Gives the planner a task, and awaits its answer: kind and parameters as in a scenario's section `task`; "hold" ends all
        motion, "scenario" gives the scenario's own back. @raises Refused with the planner's reason, NoAnswer"""
        request = self._new_id()
        return self._ask("task/target", target_sample(kind, parameters, request), {request: "planner"}, timeout)[0]

    def weights(self, weights: Mapping[str, float], timeout: float = 5.0) -> Reply:
        """Gives the planner other weights of Algorithm 1, by their keys below planner.weights of a scenario that allows it
        ({"roll.Q.ball_xy": 2e5}; `c3rt weights list` names them); {}: all are the scenario's again. @raises Refused, NoAnswer"""
        request = self._new_id()
        return self._ask("planner/weights", weights_sample(weights, request), {request: "planner"}, timeout)[0]

    def stop(self, timeout: float = 5.0) -> List[Reply]:
        """Stops the robot until recover(). @raises Refused, NoAnswer"""
        return self._request(types.RequestVerb.REQUEST_STOP, timeout)

    def recover(self, timeout: float = 5.0) -> List[Reply]:
        """Ends a reflex or a stop, and awaits that the robot moves again. @raises Refused with the reason, NoAnswer"""
        return self._request(types.RequestVerb.REQUEST_RECOVER, timeout)

    def shutdown(self, process: str, timeout: float = 5.0) -> Reply:
        """Ends one process; `c3rt up` starts it again. @raises Refused, NoAnswer"""
        request = self._new_id()
        sample = types.ServiceRequest(request, process=process_of(process), verb=types.RequestVerb.REQUEST_SHUTDOWN)
        return self._ask("service/request", sample, {request: process}, timeout)[0]

    def fault(self, process: str, kind: str, index: int = 0, duration_s: float = 0.0, value: Sequence[float] = (0.0, 0.0, 0.0),
              timeout: float = 5.0) -> Reply:
        """Injects a fault (`c3rt fault --help`): index of camera or object, value an impulse [N s]. @raises Refused, NoAnswer"""
        if kind not in FAULTS:
            raise ValueError(f"kind: expected one of {', '.join(FAULTS)}, got {kind!r}")
        numbers = _numbers("value", value)
        if len(numbers) != 3:
            raise ValueError(f"value: expected 3 numbers, got {len(numbers)}")
        request = self._new_id()
        sample = types.FaultInject(process_of(process), request_id=request, kind=FAULTS[kind], index=index,
                                   duration_s=float(duration_s), value=numbers)
        return self._ask("fault/inject", sample, {request: process}, timeout)[0]

    # ---- what a person does to the robot itself; answered once it has obeyed

    def guide(self, axes: Sequence[str] = AXES, elbow: bool = True, timeout: float = 5.0) -> Reply:
        """Takes the arm by the hand, while nothing moves it: along and about these axes of the world, and at the elbow.
        @raises Refused with the reason, NoAnswer"""
        for axis in axes:
            if axis not in AXES:
                raise ValueError(f"axes: expected of {', '.join(AXES)}, got {axis!r}")
        return self._order(timeout, kind=types.OrderKind.ORDER_GUIDING, engaged=True, free_elbow=bool(elbow),
                           free_axes=sum(1 << AXES.index(axis) for axis in set(axes)))

    def release(self, timeout: float = 5.0) -> Reply:
        """Lets go of the arm."""
        return self._order(timeout, kind=types.OrderKind.ORDER_GUIDING)

    def user_stop(self, pressed: bool, timeout: float = 5.0) -> Reply:
        """Presses the robot's stop button, or releases it; then recover() ends the stop. @raises Refused, NoAnswer"""
        return self._order(timeout, kind=types.OrderKind.ORDER_USER_STOP, engaged=bool(pressed))

    def thresholds(self, nominal: Thresholds, acceleration: Optional[Thresholds] = None, timeout: float = 5.0) -> Reply:
        """Sets thresholds of contact and collision, while nothing moves the robot; acceleration: while a joint accelerates,
        not given: as nominal. @raises Refused with the reason, NoAnswer"""
        return self._order(timeout, kind=types.OrderKind.ORDER_THRESHOLDS, nominal=nominal.sample(),
                           acceleration=(acceleration or nominal).sample())

    def push(self, force: Sequence[float], duration: float, timeout: float = 5.0) -> Reply:
        """Pushes the end effector: force [N] in the world's axes, duration [s]. @raises Refused, NoAnswer"""
        numbers = _numbers("force", force)
        if len(numbers) != 3:
            raise ValueError(f"force: expected 3 numbers, got {len(numbers)}")
        return self._order(timeout, kind=types.OrderKind.ORDER_PUSH, force_W_n=numbers, duration_s=float(duration))

    # ---- ending

    def close(self) -> None:
        """Leaves the bus; a second time nothing happens."""
        self._readers.clear()
        self._writers.clear()
        self._bus.close()

    def __enter__(self) -> Client:
        return self

    def __exit__(self, kind: Optional[Type[BaseException]], error: Optional[BaseException],
                 trace: Optional[TracebackType]) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"Client(domain={self._bus.domain}, profile={self._bus.profile!r})"

    def _own_reader(self, name: str, depth: int) -> Reader[Any]:
        return Reader(self._bus, TOPICS[name].name, depth)

    def _new_id(self) -> int:
        self._next_id += 1
        return self._next_id

    def _request(self, verb: types.RequestVerb, timeout: float) -> List[Reply]:
        asked = {self._new_id(): name for name in ("plant", "impedance", "planner")}
        samples = [types.ServiceRequest(request, process=process_of(name), verb=verb) for request, name in asked.items()]
        for sample in samples[:-1]:
            self._send("service/request", sample)
        return self._ask("service/request", samples[-1], asked, timeout)

    def _order(self, timeout: float, **fields: Any) -> Reply:
        request = self._new_id()
        return self._ask("robot/order", types.RobotOrder(request_id=request, **fields), {request: "plant"}, timeout)[0]

    def _send(self, topic: str, sample: Any) -> None:
        self._bus.require_open()
        if topic not in self._writers:
            self._writers[topic] = Writer(self._bus, topic)
        self._writers[topic].write(sample, self._bus.now_ns())

    def _ask(self, topic: str, sample: Any, asked: Dict[int, str], timeout: float) -> List[Reply]:
        self._send(topic, sample)
        answers: Dict[int, Reply] = {}
        end = time.monotonic() + timeout
        while len(answers) < len(asked):
            for reply in self._replies.take():
                if reply.request_id not in asked:
                    continue
                name = PROCESSES[reply.process.value]
                if not reply.ok:
                    raise Refused(f"{name}: {reply.text}")
                answers[reply.request_id] = Reply(name, reply.text)
            left = end - time.monotonic()
            if len(answers) < len(asked) and left <= 0.0:
                missing = ", ".join(name for request, name in asked.items() if request not in answers)
                raise NoAnswer(f"{missing} did not answer for {timeout:g} s on domain {self._bus.domain}, profile "
                               f"{self._bus.profile}: c3rt status tells what runs")
            self._replies.sleep(min(left, SLICE_S))
        return [answers[request] for request in asked]
