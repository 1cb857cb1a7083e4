"""A planner or an estimator of one's own: a class with one method, in the plant's time or in real time."""

from __future__ import annotations

import argparse
import os
import signal
import threading
import time
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt

import c3rt.v2 as types

from ._bus import PROCESSES, SLICE_S, Bus, Reader, Writer
from ._errors import WrongClock

Vector = npt.NDArray[np.float64]

JOINING = -1  # time of a Done that answers no tick
JOIN_AGAIN_S = 0.2
GONE_S = 0.5  # without a writer of ticks the run is over
PATIENCE_S = 10.0  # of what a tick promises
STATUS_S = 0.1
SPEED_OVER_NS = 4_000_000  # the end effector's velocity is a difference over at least this
TOOL_DOWN = (0.0, 1.0, 0.0, 0.0)
STATES = types.ServiceState


def _vector(name: str, value: Any, size: int) -> List[float]:
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError) as error:
        raise TypeError(f"{name}: expected {size} numbers, got {value!r}") from error
    if array.shape != (size,):
        raise ValueError(f"{name}: expected the shape ({size},), got {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"{name}: expected finite numbers, got {array.tolist()}")
    return [float(number) for number in array]


def _quaternion(name: str, value: Any) -> List[float]:
    q = np.array(_vector(name, value, 4))
    norm = float(np.linalg.norm(q))
    if norm < 1e-9:
        raise ValueError(f"{name}: expected a quaternion w x y z, got zeros")
    return [float(number) for number in q / norm]


class Effector(NamedTuple):
    """The end effector and its arm, from robot/state."""

    p: Vector  # p_WE [m]
    v: Vector  # of the last two states [m/s]
    q: Vector  # of the joints [rad]
    dq: Vector  # [rad/s]
    moves: bool  # follows commands: not stopped, in no reflex


class Object(NamedTuple):
    """The newest object/estimate of an object."""

    index: int
    name: str
    valid: bool  # False: lost, the numbers are the last good ones
    p: Vector  # p_WB of the centre of mass [m]
    q: Vector  # w x y z
    v: Vector  # [m/s]
    omega: Vector  # in W [rad/s]
    age: float  # since the exposure [s]


class Situation(NamedTuple):
    """What a planner plans from."""

    time: float  # of the session's clock [s]
    effector: Effector
    objects: Dict[int, Object]  # by their index in the scenario


class Knot(NamedTuple):
    """Where the end effector shall be, `after` seconds from the time when the plan takes effect."""

    p: Any  # p_WE [m]
    v: Any = (0.0, 0.0, 0.0)  # [m/s]
    q: Any = TOOL_DOWN  # w x y z
    force: Any = (0.0, 0.0, 0.0)  # of the contacts on the end effector, in W [N]
    after: float = 0.0


class Estimate(NamedTuple):
    """Where an object is seen."""

    index: int  # in the scenario
    p: Any  # p_WB of the centre of mass [m]
    q: Any = (1.0, 0.0, 0.0, 0.0)  # w x y z
    v: Any = (0.0, 0.0, 0.0)  # [m/s]
    omega: Any = (0.0, 0.0, 0.0)  # in W [rad/s]
    valid: bool = True
    name: str = ""


class JointPositions(NamedTuple):
    """Where the joints shall be a cycle later."""

    q: Any  # [rad]
    finished: bool = False  # the last one: the robot is idle again


class JointVelocities(NamedTuple):
    """How fast the joints shall be."""

    dq: Any  # [rad/s]
    finished: bool = False


class CartesianPose(NamedTuple):
    """Where the end effector shall be a cycle later."""

    p: Any  # p_WE [m]
    q: Any = TOOL_DOWN  # w x y z
    elbow: Any = None  # position of joint 3 [rad] and sign of joint 4 (-1 or 1); None: as it comes
    finished: bool = False


class CartesianVelocities(NamedTuple):
    """How fast the end effector shall be."""

    v: Any  # [m/s]
    omega: Any = (0.0, 0.0, 0.0)  # in W [rad/s]
    elbow: Any = None
    finished: bool = False


Command = Union[JointPositions, JointVelocities, CartesianPose, CartesianVelocities]


class _Process:
    """The part of a process of c3rt: its clock, its status, its share of requests."""

    name = ""  # of the process whose part it plays
    rate_hz = 100.0

    # ---- for a person

    def run(self, domain: int = 0, profile: str = "loopback", clock: str = "realtime", session: int = 0) -> None:
        """Plays the process until Ctrl-C, SIGTERM or a shutdown request, in lockstep until the run is over.

        What the method raises ends it, as failed in service/status. @raises ValueError, TypeError for a wrong argument, WrongClock"""
        if clock not in ("realtime", "lockstep"):
            raise ValueError(f"clock: expected realtime or lockstep, got {clock!r}")
        if not (isinstance(self.rate_hz, (int, float)) and 1.0 <= self.rate_hz <= 1000.0):
            raise ValueError(f"rate_hz: expected a number from 1 to 1000, got {self.rate_hz!r}")
        lockstep = clock == "lockstep"
        self._stop = threading.Event()
        self._state, self._text = STATES.SERVICE_RUNNING, "waiting for the robot's state"
        self._stopped = False
        self._cycles = 0
        self._counters: Dict[str, int] = {"cycles": 0, "overruns": 0, "requests": 0}
        before = self._take_signals()
        bus = self._bus = Bus(domain, profile, lockstep, self.name)
        bus.session = session
        status: Optional[threading.Thread] = None
        try:
            self._inputs: List[Reader[Any]] = []
            self._outputs: List[Writer] = []
            self._open()
            self._status = Writer(bus, "service/status")
            self._reply = Writer(bus, "service/reply")
            self._requests: Reader[Any] = Reader(bus, "service/request", 64)
            self._faults: Reader[Any] = Reader(bus, "fault/inject", 64)
            self._lock = threading.Lock()
            status = threading.Thread(target=self._serve, name="status", daemon=True)
            status.start()
            try:
                self._in_lockstep() if lockstep else self._in_realtime()
                self._state, self._text = STATES.SERVICE_STOPPING, "stopping"
            except BaseException as error:
                self._state = STATES.SERVICE_FAILED
                self._text = f"{type(error).__name__}: {error}"
                raise
        except KeyboardInterrupt:
            pass
        finally:
            self._stop.set()
            if status is not None:
                status.join()
            bus.close()
            for number, handler in before.items():
                signal.signal(number, handler)

    def main(self, arguments: Optional[Sequence[str]] = None) -> None:
        """run() with the words of a command line, also those that c3rt gives its own processes."""
        words = argparse.ArgumentParser(description=(self.__doc__ or "").strip().split("\n")[0] or f"plays {self.name}")
        words.add_argument("scenario", nargs="?", help="taken and not read: c3rt gives it to its processes")
        words.add_argument("--domain", type=int, default=0, help="DDS domain, that of c3rt run or up")
        words.add_argument("--profile", "--dds-profile", default="loopback", help="a name or a DDS profile's file")
        words.add_argument("--clock", choices=("realtime", "lockstep"), default="realtime")
        words.add_argument("--session", type=int, default=0, help="of the plant; 0: the one that is heard")
        words.add_argument("--seed", type=int, default=1, help=argparse.SUPPRESS)
        words.add_argument("--set", action="append", help=argparse.SUPPRESS)
        given = words.parse_args(arguments)
        try:
            self.run(given.domain, given.profile, given.clock, given.session)
        except (WrongClock, ConnectionError) as error:
            words.exit(2, f"{words.prog}: error: {error}\n")

    def say(self, text: str, degraded: bool = False) -> None:
        """A sentence for `c3rt status`."""
        self._state = STATES.SERVICE_DEGRADED if degraded else STATES.SERVICE_RUNNING
        self._text = text

    # ---- for a kind of process

    def _open(self) -> None:
        raise NotImplementedError

    def _step(self, now_ns: int) -> bool:
        """@return whether there was something to do, which counts as a cycle"""
        raise NotImplementedError

    def _input(self, topic: str, depth: int = 1) -> Reader[Any]:
        reader: Reader[Any] = Reader(self._bus, topic, depth)
        self._inputs.append(reader)
        return reader

    def _output(self, topic: str) -> Writer:
        writer = Writer(self._bus, topic)
        self._outputs.append(writer)
        return writer

    def _pause(self, seconds: float) -> None:
        """Until the next cycle, or something that it answers."""
        self._stop.wait(seconds)

    # ---- clocks

    def _period_ns(self) -> int:
        return round(1e9 / self.rate_hz)

    def _in_realtime(self) -> None:
        period = self._period_ns()
        due = time.monotonic_ns()
        while not self._stop.is_set():
            left = due - time.monotonic_ns()
            if left > 0:
                self._pause(min(left * 1e-9, SLICE_S))
                continue
            self._cycle(time.monotonic_ns())
            missed = (time.monotonic_ns() - due) // period
            self._counters["overruns"] += missed
            due += (missed + 1) * period

    def _in_lockstep(self) -> None:
        ticks: Reader[Any] = Reader(self._bus, "sim/tick", 64, self.name)
        done = Writer(self._bus, "sim/done")
        for reader in self._inputs:
            if reader.topic.stream >= 0:
                reader.allowed = 0
        period, next_due, tick_ns = self._period_ns(), 0, JOINING
        while True:
            written = [0] * types.TOPIC_COUNT
            for writer in self._outputs:
                if writer.topic.stream >= 0:
                    written[writer.topic.stream] = writer.seq
            answer = types.Done(types.Process(PROCESSES.index(self.name)), next_due_ns=next_due, newest_seq=written)
            done.write(answer, tick_ns)
            tick = self._next_tick(ticks, done, answer, tick_ns, next_due)
            if tick is None:
                return
            self._await_promised(tick)
            tick_ns = tick.header.time_ns
            next_due = (tick_ns // period + 1) * period
            self._cycle(tick_ns)

    def _next_tick(self, ticks: Reader[Any], done: Writer, answer: Any, tick_ns: int, next_due: int) -> Any:
        answered = seen = time.monotonic()
        bit = 1 << PROCESSES.index(self.name)
        while not self._stop.is_set():
            for tick in ticks.take():
                if tick.due & bit and tick.header.time_ns >= next_due:
                    return tick
            now = time.monotonic()
            if ticks.writers() > 0:
                seen = now
            if tick_ns != JOINING and now - seen > GONE_S:
                return None  # the run is over
            if tick_ns == JOINING and self._inputs[0].refused_by_quality():
                raise WrongClock(f"the run is in realtime, this {self.name} in lockstep: clock=\"realtime\", --clock realtime")
            if tick_ns == JOINING and now - answered > JOIN_AGAIN_S:
                done.write(answer, tick_ns)  # the plant may have come after the first one
                answered = now
            ticks.sleep(SLICE_S)
        return None

    def _await_promised(self, tick: Any) -> None:
        end = time.monotonic() + PATIENCE_S
        for reader in self._inputs:
            if reader.topic.stream < 0:
                continue
            promised = tick.newest_seq[reader.topic.stream]
            reader.pump()
            while reader.newest_seq < promised:
                if self._stop.is_set():
                    return
                if time.monotonic() > end:
                    raise RuntimeError(f"the tick of {tick.header.time_ns * 1e-9:.6g} s promises a sample of {reader.topic.name} "
                                       f"that did not arrive for {PATIENCE_S:g} s")
                reader.sleep(SLICE_S)
                reader.pump()
            reader.allowed = promised

    def _cycle(self, now_ns: int) -> None:
        if not self._bus.lockstep and self._inputs[0].is_of_lockstep():
            raise WrongClock(f"the run is in lockstep, this {self.name} in realtime: clock=\"lockstep\", --clock lockstep")
        if self._step(now_ns):
            self._counters["cycles"] += 1

    # ---- status and requests, in a thread of their own

    def _serve(self) -> None:
        began, cycles, rate = time.monotonic(), 0, 0.0
        while True:
            ended = self._stop.wait(STATUS_S)
            now = time.monotonic()
            if now - began >= 1.0:
                rate = (self._counters["cycles"] - cycles) / (now - began)
                began, cycles = now, self._counters["cycles"]
            self._tell(rate)
            if ended:
                return
            self._answer()

    def _tell(self, rate: float) -> None:
        status = types.ServiceStatus(types.Process(PROCESSES.index(self.name)), pid=os.getpid(), state=self._state,
                                     text=_cut(self._text, 511), rate_hz=rate)
        for i, (name, count) in enumerate(self._counters.items()):
            status.counter_names[i], status.counters[i] = name, count
        self._status.write(status, time.monotonic_ns())

    def _answer(self) -> None:
        for request in self._requests.take():
            if PROCESSES[request.process.value] != self.name:
                continue
            self._counters["requests"] += 1
            ok, text = self._obey(request.verb)
            self._say_to(request.request_id, ok, text)
        for fault in self._faults.take():
            if PROCESSES[fault.process.value] == self.name:
                self._say_to(fault.request_id, False, "refused: a client plays this process, and it has no faults")

    def _obey(self, verb: types.RequestVerb) -> Tuple[bool, str]:
        if verb == types.RequestVerb.REQUEST_SHUTDOWN:
            self._stop.set()
            return True, f"{self.name} is shutting down"
        self._stopped = verb == types.RequestVerb.REQUEST_STOP
        return True, "holding until recover" if self._stopped else "goes on"

    def _say_to(self, request_id: int, ok: bool, text: str) -> None:
        if request_id == 0:
            return
        with self._lock:
            self._reply.write(types.ServiceReply(request_id, process=types.Process(PROCESSES.index(self.name)), ok=ok,
                                                 text=_cut(text, 511)), time.monotonic_ns())

    def _take_signals(self) -> Dict[int, Any]:
        """Ctrl-C and SIGTERM end run(); not where it runs in another thread than the main one, which alone gets them."""
        if threading.current_thread() is not threading.main_thread():
            return {}
        return {number: signal.signal(number, lambda *_: self._stop.set()) for number in (signal.SIGINT, signal.SIGTERM)}


def _cut(text: str, size: int) -> str:
    return text.encode()[:size].decode(errors="ignore")


class Planner(_Process):
    """A planner of one's own. Override plan(); set rate_hz, and phase while it runs."""

    name = "planner"
    delay_s = 0.0075  # a plan takes effect this long after the state that it was made from
    valid_for_s = 0.1  # after that the arm holds
    phase = "roll"  # "wait", "approach", "rest" and "hold" are the way to the task; with any other word it has begun

    def plan(self, now: Situation) -> Union[Knot, Sequence[Knot], None]:
        """Once a period. @return a state to follow, a motion of 1 to 16 knots, or None: nothing is sent"""
        raise NotImplementedError("plan(self, now) says where the end effector shall be")

    def target(self, kind: str, parameters: Mapping[str, Union[str, List[float]]]) -> None:
        """A client's task. @raises ValueError saying why it is not taken; here none is"""
        raise ValueError("a client plays the planner, and it takes no targets")

    def _open(self) -> None:
        self._states = self._input("robot/state", 64)
        self._estimates = self._input("object/estimate", 64)
        self._targets: Reader[Any] = Reader(self._bus, "task/target", 16)
        self._plans = self._output("plan")
        self._state_now: Any = None
        self._earlier: List[Any] = []  # states, the newest last
        self._seen: Dict[int, Any] = {}
        self._hold: Optional[List[float]] = None

    def _step(self, now_ns: int) -> bool:
        self._take(now_ns)
        for target in self._targets.take():
            self._take_target(target)
        if self._state_now is None:
            return False
        if self._text == "waiting for the robot's state":
            self.say("plans")
        began = time.perf_counter()
        knots: Sequence[Knot]
        phase = self.phase
        if self._stopped:
            if self._hold is None:
                self._hold = list(self._state_now.p_WE_m)
            knots, phase = [Knot(self._hold)], "hold"
        else:
            self._hold = None
            planned = self.plan(self._situation(now_ns))
            phase = self.phase
            if planned is None:
                return True
            knots = [planned] if isinstance(planned, Knot) else list(planned)
        effective = now_ns + round(self.delay_s * 1e9)
        if not self._bus.lockstep:
            effective = max(effective, time.monotonic_ns())
        self._plans.write(self._sample(knots, phase, effective, time.perf_counter() - began), effective)
        return True

    def _take(self, now_ns: int) -> None:
        for state in self._states.take_effective(now_ns):
            self._earlier.append(state)
        if self._earlier:
            self._state_now = self._earlier[-1]
            newest = self._state_now.header.time_ns
            while len(self._earlier) > 2 and newest - self._earlier[1].header.time_ns >= SPEED_OVER_NS:
                self._earlier.pop(0)
        for estimate in self._estimates.take_effective(now_ns):
            self._seen[estimate.object_index] = estimate

    def _take_target(self, sample: Any) -> None:
        parameters = {p.name: p.word or list(p.values[: p.value_count]) for p in sample.parameters[: sample.parameter_count]}
        try:
            self.target(sample.kind, parameters)
            self._say_to(sample.request_id, True, sample.kind)
        except ValueError as error:
            self._say_to(sample.request_id, False, f"refused: {error}")

    def _situation(self, now_ns: int) -> Situation:
        state, before = self._state_now, self._earlier[0]
        p = np.array(state.p_WE_m)
        since = (state.header.time_ns - before.header.time_ns) * 1e-9
        v = (p - np.array(before.p_WE_m)) / since if since > 0.0 else np.zeros(3)
        effector = Effector(p, v, np.array(state.q_rad), np.array(state.dq_rad_per_s),
                            state.mode in (types.RobotMode.ROBOT_MOVE, types.RobotMode.ROBOT_IDLE))
        objects = {index: Object(index, seen.name, seen.valid, np.array(seen.p_WB_m), np.array(seen.q_WB),
                                 np.array(seen.v_WB_m_per_s), np.array(seen.omega_rad_per_s),
                                 (now_ns - seen.exposure_ns) * 1e-9) for index, seen in sorted(self._seen.items())}
        return Situation(now_ns * 1e-9, effector, objects)

    def _sample(self, knots: Sequence[Knot], phase: str, effective: int, solve_time: float) -> Any:
        if not 1 <= len(knots) <= types.MAX_KNOTS:
            raise ValueError(f"plan(): expected 1 to {types.MAX_KNOTS} knots, got {len(knots)}")
        if not (isinstance(phase, str) and 0 < len(phase.encode()) <= 31):
            raise ValueError(f"phase: expected a text of 1 to 31 bytes, got {phase!r}")
        plan = types.Plan(phase=phase, solve_time_s=solve_time, knot_count=len(knots),
                          valid_until_ns=effective + round(self.valid_for_s * 1e9))
        plan.origin.state_ns = self._state_now.header.time_ns
        if self._seen:
            seen = self._seen[min(self._seen)]
            plan.origin.exposure_ns, plan.origin.estimate_ns = seen.exposure_ns, seen.header.time_ns
        last = None
        for i, (knot, place) in enumerate(zip(knots, plan.knots)):
            if not isinstance(knot, Knot):
                raise TypeError(f"plan(): expected a Knot or several, got {knot!r}")
            if last is not None and not knot.after > last:
                raise ValueError(f"knots[{i}].after: expected more than that before ({last:g} s), got {knot.after!r}")
            last = knot.after
            place.time_ns = effective + round(knot.after * 1e9)
            place.p_WE_m = _vector(f"knots[{i}].p", knot.p, 3)
            place.v_WE_m_per_s = _vector(f"knots[{i}].v", knot.v, 3)
            place.q_WE = _quaternion(f"knots[{i}].q", knot.q)
            place.force_E_n = _vector(f"knots[{i}].force", knot.force, 3)
        return plan


class Mover(_Process):
    """A motion generator of one's own, in the place of impedance. Override move()."""

    name = "impedance"
    rate_hz = 1000.0

    def move(self, time_s: float, now: Effector) -> Optional[Command]:
        """Once a cycle of the robot. @return what the arm shall do until the next; None: nothing is sent, which the robot
        extrapolates, and after 20 of them it stops"""
        raise NotImplementedError("move(self, time_s, now) says what the arm shall do")

    def _open(self) -> None:
        self._states = self._input("robot/state", 64)
        self._motions = self._output("robot/motion")
        self._before: Any = None

    def _in_realtime(self) -> None:
        # each state of the robot is answered at once
        while not self._stop.is_set():
            if self._states.wait(SLICE_S):
                self._cycle(time.monotonic_ns())

    def _step(self, now_ns: int) -> bool:
        came = self._states.take_effective(now_ns)
        if not came:
            return False
        if self._text == "waiting for the robot's state":
            self.say("moves the arm")
        state, before = came[-1], self._before or came[-1]
        self._before = state
        since = (state.header.time_ns - before.header.time_ns) * 1e-9
        p = np.array(state.p_WE_m)
        v = (p - np.array(before.p_WE_m)) / since if since > 0.0 else np.zeros(3)
        moves = state.mode in (types.RobotMode.ROBOT_MOVE, types.RobotMode.ROBOT_IDLE)
        command = None
        if not self._stopped:
            command = self.move(state.header.time_ns * 1e-9,
                                Effector(p, v, np.array(state.q_rad), np.array(state.dq_rad_per_s), moves))
        if command is None:
            return True
        sample = self._sample(command)
        sample.origin.state_ns = state.header.time_ns
        self._motions.write(sample, now_ns if self._bus.lockstep else time.monotonic_ns())
        return True

    def _sample(self, command: Command) -> Any:
        kinds = types.MotionKind
        if isinstance(command, JointPositions):
            sample = types.RobotMotion(kind=kinds.MOTION_JOINT_POSITION, q_rad=_vector("q", command.q, 7))
        elif isinstance(command, JointVelocities):
            sample = types.RobotMotion(kind=kinds.MOTION_JOINT_VELOCITY, dq_rad_per_s=_vector("dq", command.dq, 7))
        elif isinstance(command, CartesianPose):
            sample = types.RobotMotion(kind=kinds.MOTION_CARTESIAN_POSE, p_WE_m=_vector("p", command.p, 3),
                                       q_WE=_quaternion("q", command.q))
        elif isinstance(command, CartesianVelocities):
            sample = types.RobotMotion(kind=kinds.MOTION_CARTESIAN_VELOCITY, v_WE_m_per_s=_vector("v", command.v, 3),
                                       omega_WE_rad_per_s=_vector("omega", command.omega, 3))
        else:
            raise TypeError("move(): expected JointPositions, JointVelocities, CartesianPose or CartesianVelocities, "
                            f"got {command!r}")
        elbow = getattr(command, "elbow", None)
        if elbow is not None:
            sample.has_elbow = True
            sample.elbow_q3_rad, sample.elbow_sign = _vector("elbow", elbow, 2)
        sample.finished = bool(command.finished)
        return sample


class Estimator(_Process):
    """An estimator or a camera of one's own, in vision's place. Override estimate(); rate_hz is at most the exposures'."""

    name = "vision"
    rate_hz = 80.0
    of_exposures = True  # estimate() is called for each exposure of the emulated cameras; False: at rate_hz, of images of one's own
    latency_s = 0.008  # lockstep: from the exposure until the estimate is in effect

    def estimate(self, time_s: float, truth: Any) -> Sequence[Estimate]:
        """Once an exposure. time_s: of the exposure; truth: sim/scene at that time, of an emulated plant, else None"""
        raise NotImplementedError("estimate(self, time_s, truth) says where the objects are")

    def _open(self) -> None:
        self._scenes = self._input("sim/scene", 64)
        self._estimates = self._output("object/estimate")
        self._truth: Any = None

    def _pause(self, seconds: float) -> None:
        if self.of_exposures:
            self._scenes.sleep(seconds)
        else:
            self._stop.wait(seconds)

    def _in_realtime(self) -> None:
        if not self.of_exposures:
            super()._in_realtime()
            return
        while not self._stop.is_set():
            if self._scenes.wait(SLICE_S):
                self._cycle(time.monotonic_ns())

    def _step(self, now_ns: int) -> bool:
        came = self._scenes.take_effective(now_ns)
        if came:
            self._truth = came[-1]
        if not self.of_exposures:
            self._write(now_ns, self.estimate(now_ns * 1e-9, self._truth))
            return True
        exposures = [scene for scene in came if scene.exposure]
        for scene in exposures:
            self._write(scene.header.time_ns, self.estimate(scene.header.time_ns * 1e-9, scene))
        return bool(exposures)

    def _write(self, exposure_ns: int, estimates: Sequence[Estimate]) -> None:
        if self._text == "waiting for the robot's state":
            self.say("sees")
        for estimate in estimates:
            if not isinstance(estimate, Estimate):
                raise TypeError(f"estimate(): expected a list of Estimate, got {estimate!r}")
            if not 0 <= estimate.index < types.MAX_OBJECTS:
                raise ValueError(f"index: expected 0 to {types.MAX_OBJECTS - 1}, got {estimate.index!r}")
            p, q = _vector("p", estimate.p, 3), _quaternion("q", estimate.q)
            sample = types.ObjectEstimate(estimate.index, estimate.name, exposure_ns=exposure_ns, valid=bool(estimate.valid),
                                          sensors_used=1 if estimate.valid else 0, p_measured_m=p, q_measured=q, p_WB_m=p,
                                          q_WB=q, v_WB_m_per_s=_vector("v", estimate.v, 3),
                                          omega_rad_per_s=_vector("omega", estimate.omega, 3))
            at = exposure_ns + round(self.latency_s * 1e9) if self._bus.lockstep else time.monotonic_ns()
            self._estimates.write(sample, at)
