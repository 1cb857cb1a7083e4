"""Who makes runs: here the cores of this machine."""

from __future__ import annotations

import collections
import contextlib
import ctypes
import os
import pathlib
import signal
import subprocess
import time
from dataclasses import dataclass
from typing import Callable, Deque, List, Sequence

from .files import tail
from .status import CRITERION_FAILED, DONE, PROCESS_FAILED

LOOK_S = 0.05
GRACE_S = 20.0  # a run ends its own four processes first
TAIL_LINES = 15
PR_SET_PDEATHSIG = 1
LIBC = ctypes.CDLL(None)

Stop = Callable[[], bool]


@dataclass(frozen=True)
class Job:
    """One call of `c3rt run`."""

    name: str  # "seed-0007"
    scenario: str  # its file
    scenario_text: str  # whole, for who does not have the file
    words: List[str]  # after the scenario, without --out
    folder: pathlib.Path  # of its results


@dataclass(frozen=True)
class JobEnd:
    job: int  # index into the jobs
    status: int  # exit status; PROCESS_FAILED where it was killed
    failure: str  # what went wrong, with the end of its log; empty for status 0 and 1
    wall_s: float


@dataclass(frozen=True)
class Watch:
    """What an engine tells while it works."""

    stop: Stop  # asked several times a second
    ended: Callable[[JobEnd], None]  # a job's report.json lies in its folder
    look: Callable[[int], None]  # several times a second: how many are running


# jobs, how many at once, whom to tell; returns when all have ended, or a stop is wanted: then those that were running have
# been ended and are not reported
Engine = Callable[[Sequence[Job], int, Watch], None]


def cores() -> int:
    """Those that this process may use."""
    return len(os.sched_getaffinity(0))


@dataclass
class _Running:
    index: int
    job: Job
    log: pathlib.Path
    process: "subprocess.Popen[bytes]"
    since: float

    def kill_group(self, number: int) -> None:
        """What a run started itself must not outlive it."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.process.pid, number)

    def end(self) -> JobEnd:
        wall_s = time.monotonic() - self.since
        code = self.process.returncode
        if code in (DONE, CRITERION_FAILED):
            return JobEnd(self.index, code, "", wall_s)
        reason = f"exited with status {code}" if code >= 0 else f"was killed by signal {-code} ({signal.strsignal(-code)})"
        failure = f"{self.job.name} {reason}; the end of its log ({self.log}):\n{tail(self.log, TAIL_LINES)}"
        return JobEnd(self.index, code if code >= 0 else PROCESS_FAILED, failure, wall_s)


def run_here(program: str, jobs: Sequence[Job], at_once: int, watch: Watch) -> None:
    """As many `c3rt run` at once as wanted, each in a DDS domain of its own. Their words are in FOLDER/run.log."""
    waiting: Deque[int] = collections.deque(range(len(jobs)))
    running: List[_Running] = []
    try:
        while (waiting or running) and not watch.stop():
            while waiting and len(running) < at_once:
                index = waiting.popleft()
                running.append(_start(program, index, jobs[index]))
            for run in [run for run in running if run.process.poll() is not None]:
                running.remove(run)
                run.kill_group(signal.SIGKILL)
                watch.ended(run.end())
            watch.look(len(running))
            time.sleep(LOOK_S)
    finally:
        _stop(running)


def run_alone(words: Sequence[str], log: pathlib.Path, stop: Stop) -> int:
    """Any program, whose words on standard output are in the log; what it says of its progress is seen.

    Returns its exit status, PROCESS_FAILED where it was killed; at a wish to end it is ended.
    """
    with log.open("wb") as output:
        process = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=output, preexec_fn=_alone())
    try:
        while process.poll() is None and not stop():
            time.sleep(LOOK_S)
        if process.returncode is None:
            process.terminate()
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(GRACE_S)
    finally:
        process.kill()
        process.wait()
    return process.returncode if process.returncode >= 0 else PROCESS_FAILED


def _alone() -> Callable[[], None]:
    parent = os.getpid()

    def alone() -> None:
        """In a process group of its own, so that Ctrl-C reaches only us, and dead with us however we end."""
        LIBC.prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:
            os._exit(127)
        os.setpgid(0, 0)

    return alone


def _start(program: str, index: int, job: Job) -> _Running:
    log = job.folder / "run.log"
    with log.open("wb") as output:
        process = subprocess.Popen([program, "run", job.scenario, *job.words, f"--out={job.folder}"],
                                   stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT, preexec_fn=_alone())
    return _Running(index, job, log, process, time.monotonic())


def _stop(running: Sequence[_Running]) -> None:
    for run in running:
        run.kill_group(signal.SIGTERM)
    deadline = time.monotonic() + GRACE_S
    for run in running:
        with contextlib.suppress(subprocess.TimeoutExpired):
            run.process.wait(max(0.0, deadline - time.monotonic()))
        run.kill_group(signal.SIGKILL)
        run.process.wait()
