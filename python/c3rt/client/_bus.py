"""The one place that knows Cyclone DDS: domains by profile, qualities of service, readers and writers by the rules of
docs/clients.md."""

from __future__ import annotations

import pathlib
import threading
import time
from collections import deque
from importlib import resources
from typing import Any, Deque, Dict, Generic, Iterator, List, NamedTuple, Optional, Tuple, TypeVar, Union

try:
    from cyclonedds._clayer import ddspy_take
    from cyclonedds.core import DDSException, InstanceState, ReadCondition, SampleState, ViewState, WaitSet
    from cyclonedds.domain import Domain, DomainParticipant
    from cyclonedds.pub import DataWriter, Publisher
    from cyclonedds.qos import Policy, Qos
    from cyclonedds.sub import DataReader, Subscriber
    from cyclonedds.topic import Topic as DdsTopic
    from cyclonedds.util import duration
except ImportError as error:
    raise ImportError("c3rt.client needs the package cyclonedds: pip install './python[dds]' (docs/clients.md)") from error

import c3rt.v2 as types
from c3rt._core import refusal

from ._errors import NoAnswer
from ._topics import ROWS

T = TypeVar("T")

PROCESSES = ("plant", "impedance", "planner", "vision", "recorder")
LAST_DOMAIN = 230
STRENGTH = 100  # that c3rt's own processes offer
LOCKSTEP_DEPTH = 256
EVENT_DEPTH = 16
SILENCE_NS = 500_000_000  # a leader that is silent for so long may be replaced by one of its strength
PLAIN_CDR = 1  # little endian, in the second byte of what crosses the network
ANY = SampleState.Any | ViewState.Any | InstanceState.Any
SLICE_S = 0.1  # a blocked wait looks at signals this often


class Topic(NamedTuple):
    """A row of idl/topics.hpp."""

    name: str
    type: str
    quality: str
    writer: str  # the one process that writes it, or ""
    deadline_s: float
    addressed: bool
    stream: int  # its place in Tick.newest_seq, or -1


TOPICS: Dict[str, Topic] = {row[0]: Topic(*row) for row in ROWS}


def topic_of(topic: Union[str, type]) -> Topic:
    """By its name or by its type, of which each topic has one of its own."""
    for row in TOPICS.values():
        if topic == row.name or topic is getattr(types, row.type):
            return row
    if isinstance(topic, type):
        raise ValueError(f"topic: expected a type of c3rt.v2 that a topic has, got {topic.__name__}")
    raise ValueError(f"topic: expected one of {', '.join(TOPICS)}, got {topic!r}")


def writer_qos(topic: Topic, lockstep: bool = False, process: str = "") -> Qos:
    """@param process whose part is played; it is obeyed in lockstep only with its strength"""
    reliable = Policy.Reliability.Reliable(duration(seconds=30) if lockstep else duration(milliseconds=10))
    synced = lockstep and topic.quality in ("stream", "report", "plan") or topic.quality == "sync"
    policies: List[Any] = [Policy.WriterDataLifecycle(autodispose=False)]
    best_effort = topic.quality in ("stream", "report") and not lockstep
    policies.append(Policy.Reliability.BestEffort if best_effort else reliable)
    depth = LOCKSTEP_DEPTH if synced else EVENT_DEPTH if topic.quality == "event" else 1
    policies.append(Policy.History.KeepLast(depth))
    if synced or topic.quality in ("event", "status"):
        policies.append(Policy.Durability.TransientLocal)
        policies.append(Policy.DurabilityService(0, Policy.History.KeepLast(depth), -1, -1, -1))
    lease_s = {"plan": 1, "status": 1, "sync": 5}.get(topic.quality)
    if lease_s is not None:
        policies.append(Policy.Liveliness.Automatic(lease_duration=duration(seconds=lease_s)))
    if process and (topic.writer or topic.quality == "sync"):
        policies.append(Policy.OwnershipStrength(STRENGTH))
    if topic.deadline_s > 0.0:
        policies.append(Policy.Deadline(round(topic.deadline_s * 1e9)))
    return Qos(*policies)


def reader_qos(topic: Topic, lockstep: bool = False, depth: int = 1) -> Qos:
    synced = lockstep and topic.quality in ("stream", "report", "plan") or topic.quality == "sync"
    best_effort = topic.quality in ("stream", "report") and not lockstep
    policies: List[Any] = [Policy.Reliability.BestEffort if best_effort else
                           Policy.Reliability.Reliable(duration(milliseconds=100))]
    policies.append(Policy.History.KeepLast(max(depth, LOCKSTEP_DEPTH) if synced else depth))
    if synced or topic.quality in ("event", "status"):
        policies.append(Policy.Durability.TransientLocal)
    return Qos(*policies)


def profiles() -> List[str]:
    """The names of the DDS profiles that the package has."""
    folder = resources.files("c3rt") / "dds"
    return sorted(entry.name[:-4] for entry in folder.iterdir() if entry.name.endswith(".xml"))


def profile_text(profile: str) -> str:
    """Of a profile by its name or file; one that wants keys is refused."""
    if not isinstance(profile, (str, pathlib.Path)):
        raise TypeError(f"profile: expected a name or a path, got {profile!r}")
    known = profiles()
    if str(profile) in known:
        text = (resources.files("c3rt") / "dds" / f"{profile}.xml").read_text()
    else:
        file = pathlib.Path(profile)
        if not file.is_file():
            raise ValueError(f"profile: expected {', '.join(known)} or a file, got {str(profile)!r}")
        text = file.read_text()
    if "<Security>" in text or "<DDSSecurity>" in text:
        raise ValueError(f"profile: {profile} wants keys, and PyPI's cyclonedds has no security plugins: "
                         "a secure bus is for programs with a Cyclone DDS that has them (docs/security.md)")
    return text


class _Domains:
    """Cyclone's state of each domain in this process, configured once and shared."""

    lock = threading.Lock()
    held: Dict[int, Tuple[Domain, str, int]] = {}

    @classmethod
    def enter(cls, domain: int, text: str) -> None:
        with cls.lock:
            if domain in cls.held:
                shared, configured, users = cls.held[domain]
                if configured != text:
                    raise ValueError(f"domain: {domain} is in use in this process with another profile")
                cls.held[domain] = (shared, configured, users + 1)
                return
            try:
                cls.held[domain] = (Domain(domain, text.encode("ascii", "replace").decode()), text, 1)
            except DDSException as error:
                raise ConnectionError(f"DDS domain {domain} cannot be joined (is it in use in this process already, or are "
                                      f"there as many programs on it as its profile allows?): {error}") from error

    @classmethod
    def leave(cls, domain: int) -> None:
        with cls.lock:
            shared, text, users = cls.held[domain]
            if users > 1:
                cls.held[domain] = (shared, text, users - 1)
            else:
                del cls.held[domain]  # which deletes it


class Bus:
    """A participant of a domain, and the session that its samples belong to."""

    def __init__(self, domain: int = 0, profile: str = "loopback", lockstep: bool = False, process: str = ""):
        if isinstance(domain, bool) or not isinstance(domain, int):
            raise TypeError(f"domain: expected a whole number from 0 to {LAST_DOMAIN}, got {domain!r}")
        if not 0 <= domain <= LAST_DOMAIN:
            raise ValueError(f"domain: expected a whole number from 0 to {LAST_DOMAIN}, got {domain}")
        self.domain, self.profile, self.lockstep, self.process = domain, profile, lockstep, process
        self.session = 0  # of the plant; 0: not heard yet
        self.told_by = ""  # the topic that told it
        self._closed = True
        _Domains.enter(domain, profile_text(profile))
        try:
            self.participant = DomainParticipant(domain)
        except DDSException as error:
            _Domains.leave(domain)
            raise ConnectionError(f"DDS domain {domain} has no room for another program: {error}") from error
        self._closed = False
        self._topics: Dict[str, DdsTopic] = {}
        self.entities: List[Any] = []

    def dds_topic(self, topic: Topic) -> DdsTopic:
        if topic.name not in self._topics:
            self._topics[topic.name] = DdsTopic(self.participant, topic.name, getattr(types, topic.type))
        return self._topics[topic.name]

    def now_ns(self) -> int:
        return time.monotonic_ns()

    def require_open(self) -> None:
        if self._closed:
            raise RuntimeError("this client is closed")

    def close(self) -> None:
        if self._closed:
            return
        self._closed = True
        for entity in list(self.entities):
            entity.close()
        self.entities.clear()
        self._topics.clear()
        del self.participant
        _Domains.leave(self.domain)


class Writer:
    """Writes samples; fills in session, sequence number and time."""

    def __init__(self, bus: Bus, name: str):
        self.topic = topic_of(name)
        self._bus = bus
        dds_topic = bus.dds_topic(self.topic)
        self._writer: Optional[DataWriter] = DataWriter(
            Publisher(bus.participant), dds_topic, writer_qos(self.topic, bus.lockstep, bus.process if bus.lockstep else ""))
        self.seq = 0
        bus.entities.append(self)

    def write(self, sample: Any, time_ns: int) -> None:
        """@raises TypeError, ValueError if a field is of another type or length than its topic's"""
        if self._writer is None:
            self._bus.require_open()
            raise RuntimeError(f"the writer of {self.topic.name} is closed")
        expected = getattr(types, self.topic.type)
        if not isinstance(sample, expected):
            raise TypeError(f"{self.topic.name}: expected a {self.topic.type}, got {type(sample).__name__}")
        sample.header = types.Header(self._bus.session if self.topic.writer else 0, self.seq + 1, int(time_ns))
        try:
            self._writer.write(sample)
        except DDSException as error:
            raise ConnectionError(f"{self.topic.name}: not sent: {error}") from error
        except Exception as error:  # of its fields
            raise ValueError(f"{self.topic.name}: expected the fields of {self.topic.type}: {error}") from error
        self.seq += 1

    def close(self) -> None:
        self._writer = None


class _Source(NamedTuple):
    participant: int
    strength: int
    reliable: bool


class Reader(Generic[T]):
    """The samples of a topic that the rules let in: of values that can be, of its one writer, in its session, in order."""

    def __init__(self, bus: Bus, name: str, depth: int = 1, address: str = ""):
        if isinstance(depth, bool) or not isinstance(depth, int):
            raise TypeError(f"depth: expected a whole number from 1, got {depth!r}")
        if depth < 1:
            raise ValueError(f"depth: expected a whole number from 1, got {depth}")
        self.topic = topic_of(name)
        self._bus = bus
        self._depth = depth
        parent: Any = bus.participant
        if self.topic.addressed:
            parent = Subscriber(bus.participant, Qos(Policy.Partition([address] if address else list(PROCESSES))))
        self._reader: Optional[DataReader] = DataReader(parent, bus.dds_topic(self.topic),
                                                        reader_qos(self.topic, bus.lockstep, depth))
        self._condition = ReadCondition(self._reader, ANY)
        self._waitset = WaitSet(bus.participant)
        self._waitset.attach(self._condition)
        keep = max(depth, LOCKSTEP_DEPTH) if bus.lockstep and self.topic.stream >= 0 else depth
        self._queue: Deque[T] = deque(maxlen=keep)
        self._sources: Dict[int, _Source] = {}  # of a writer's handle
        self._newest: Dict[Tuple[int, int], int] = {}  # of writer and session, its newest number
        self._leader: Optional[_Source] = None
        self._heard_ns = 0
        self.newest_seq = 0  # of the writer that is obeyed
        self.allowed: Optional[int] = None  # lockstep: no sample with a greater number is given out; None: all are
        self.refused = 0
        self.refusal = ""  # the newest, of a value: "plan: knot_count is 17, expected 1 to 16"
        bus.entities.append(self)

    # ---- for a person

    def take(self) -> List[T]:
        """What has come since the last call, in order; at most `depth`, the newest."""
        self._pump()
        out: List[T] = []
        while self._queue and self._may_go(self._queue[0]):
            out.append(self._queue.popleft())
        return out

    def newest(self, timeout: float = 5.0) -> T:
        """The newest sample that has not been given out, waited for. @raises NoAnswer after timeout seconds"""
        if not self.wait(timeout):
            raise NoAnswer(f"{self.topic.name}: nothing has come for {timeout:g} s on domain {self._bus.domain}, profile "
                           f"{self._bus.profile}: c3rt status tells what runs, c3rt hz {self.topic.name} whether it is written")
        return self.take()[-1]

    def wait(self, timeout: float) -> bool:
        """Until there is something to take. @return whether there is"""
        if isinstance(timeout, bool) or not isinstance(timeout, (int, float)):
            raise TypeError(f"timeout: expected seconds, got {timeout!r}")
        end = time.monotonic() + timeout
        while True:
            self._pump()
            if self._queue and self._may_go(self._queue[0]):
                return True
            left = end - time.monotonic()
            if left <= 0.0:
                return False
            self.sleep(left)

    def samples(self, timeout: float = 5.0) -> Iterator[T]:
        """Each sample as it comes, until none has come for timeout seconds."""
        while self.wait(timeout):
            yield from self.take()

    def __iter__(self) -> Iterator[T]:
        return self.samples()

    # ---- for a process

    def sleep(self, seconds: float) -> None:
        """Until something arrives, or for that long; not so long that a signal waits."""
        self._waitset.wait(round(1e9 * max(0.0, min(seconds, SLICE_S))))

    def take_effective(self, now_ns: int) -> List[T]:
        """As take(), but what is to take effect later than now waits."""
        self._pump()
        out: List[T] = []
        while self._queue and self._may_go(self._queue[0]) and self._queue[0].header.time_ns <= now_ns:
            out.append(self._queue.popleft())
        return out

    def pump(self) -> None:
        self._pump()

    def refused_by_quality(self) -> bool:
        """A writer of this topic offers less than is requested, as one in realtime does to a reader in lockstep."""
        if self._reader is None:
            return False
        status = self._reader.get_requested_incompatible_qos_status()
        return status is not None and status.total_count > 0

    def is_of_lockstep(self) -> bool:
        """One of c3rt's own processes is in lockstep: reliable where one in realtime is not."""
        return any(source.reliable for source in self._sources.values() if source.strength >= STRENGTH)

    def writers(self) -> int:
        """How many writers there are."""
        if self._reader is None:
            self._bus.require_open()
            return 0
        return len(self._reader.get_matched_publications())

    def close(self) -> None:
        """Ends the subscription: nothing more comes."""
        if self._reader is None:
            return
        self._queue.clear()
        self._reader = None
        del self._condition, self._waitset
        self._bus.entities.remove(self)

    def _may_go(self, sample: Any) -> bool:
        return self.allowed is None or sample.header.seq <= self.allowed

    def _pump(self) -> None:
        if self._reader is None:
            self._bus.require_open()
            return
        fresh: List[Any] = []
        while True:
            came = ddspy_take(self._reader._ref, ANY, LOCKSTEP_DEPTH)
            if isinstance(came, int):
                raise ConnectionError(f"{self.topic.name}: cannot be read: {DDSException(came)}")
            fresh += [sample for data, info in came if info.valid_data and (sample := self._sample(data, info)) is not None]
            if len(came) < LOCKSTEP_DEPTH:
                break
        # DDS hands out instance by instance: back into the order in which each writer wrote
        fresh.sort(key=lambda sample: (sample.sample_info.publication_handle, sample.header.seq))
        for sample in fresh:
            if self._lets_in(sample):
                self._queue.append(sample)
            else:
                self.refused += 1

    def _sample(self, data: bytes, info: Any) -> Any:
        """Of its bytes, which are looked at before anything is made of them. @return None: refused"""
        kind = getattr(types, self.topic.type)
        if data[1] != PLAIN_CDR:  # the representation that others may choose instead
            try:
                data = kind.deserialize(data).serialize()
            except Exception:  # bytes of no sample: what is raised depends on where they end
                data = b""
        why = refusal(self.topic.name, data)
        if why:
            self.refused += 1
            self.refusal = f"{self.topic.name}: {why}"
            return None
        sample = kind.deserialize(data)
        sample.sample_info = info
        return sample

    def _lets_in(self, sample: Any) -> bool:
        header, handle = sample.header, sample.sample_info.publication_handle
        source = self._source(handle)
        if self.topic.quality == "sync" and source.strength < STRENGTH:
            return False
        if self.topic.writer and not self._obeys(source):
            return False
        if self.topic.writer == "plant" and header.session_id != self._bus.session:
            # once the robot's state has been heard, no scene tells of another plant
            if self.topic.name != "robot/state" and self._bus.told_by == "robot/state":
                return False
            self._bus.session, self._bus.told_by = header.session_id, self.topic.name
        if self._bus.session and header.session_id not in (0, self._bus.session):
            return False
        if header.seq <= self._newest.get((handle, header.session_id), 0):
            return False
        self._newest[handle, header.session_id] = header.seq
        self.newest_seq = header.seq
        return True

    def _source(self, handle: int) -> _Source:
        if handle not in self._sources:
            assert self._reader is not None
            data = self._reader.get_matched_publication_data(handle)
            strength, reliable = 0, False
            if data is not None and data.qos is not None:
                offered = data.qos[Policy.OwnershipStrength]
                strength = offered.strength if offered is not None else 0
                reliable = isinstance(data.qos[Policy.Reliability], Policy.Reliability.Reliable)
            participant = handle if data is None else int(data.participant_instance_handle)
            self._sources[handle] = _Source(participant, strength, reliable)
        return self._sources[handle]

    def _obeys(self, source: _Source) -> bool:
        """The greatest strength leads, among equals the first; a weaker one waits until it has left."""
        now_ns = time.monotonic_ns()
        leader = self._leader
        if leader is not None and source.participant != leader.participant:
            silent = not self._bus.lockstep and now_ns - self._heard_ns > SILENCE_NS
            if silent and (source.strength >= leader.strength or not self._is_there(leader)):
                leader = None
        if self._bus.lockstep and source.strength < STRENGTH:
            return False
        if leader is None or source.strength > leader.strength:
            leader = self._leader = source
        if leader.participant != source.participant:
            return False
        self._heard_ns = now_ns
        return True

    def _is_there(self, leader: _Source) -> bool:
        assert self._reader is not None
        return any(self._source(handle).participant == leader.participant
                   for handle in self._reader.get_matched_publications())
