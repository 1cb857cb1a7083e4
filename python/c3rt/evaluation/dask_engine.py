"""Runs on the machines of a Dask cluster: each is one call of `c3rt run` on a worker, and its report.json comes back.

A worker needs the package `distributed`, and c3rt of the same build at the same path, or at the path in its C3RT_PROGRAM.
"""

from __future__ import annotations

import contextlib
import os
import pathlib
import signal
import time
import uuid
from typing import Any, Dict, Iterator, Sequence

from . import worker
from .engine import Job, JobEnd, Watch
from .files import write_text
from .status import PROCESS_FAILED, UsageError

LOOK_S = 0.2
STDERR = 2
GRACE_S = 20.0  # the runs on the workers end first
PROGRAMS = ("c3rt", "c3rt-plant", "c3rt-impedance", "c3rt-planner", "c3rt-vision")


def run_on_dask(program: str, address: str, jobs: Sequence[Job], at_once: int, watch: Watch) -> None:
    """As run_here.

    address: of a scheduler, tcp://host:port, whose own workers decide how many run at once; empty: a cluster of as many
    workers as wanted on this machine. UsageError if programs or the scheduler are not there.
    """
    try:
        programs = worker.hashes(program, PROGRAMS)
    except OSError as error:
        raise UsageError(f"--engine dask: cannot read {error.filename}: {error.strerror}") from None
    with _words_to(jobs[0].folder.parent / "dask.log"), contextlib.ExitStack() as stack:
        import distributed  # which takes the standard error of this moment for its words

        client = _client(distributed, stack, address, at_once)
        stop = distributed.Event(f"c3rt-stop-{uuid.uuid4()}")
        run_job = _travelling(distributed, stop.name)
        futures = {}
        for index, job in enumerate(jobs):
            future = client.submit(run_job, program, programs, job.words, pathlib.Path(job.scenario).name, job.scenario_text,
                                   pure=False)
            futures[future] = index
        while futures and not watch.stop():
            for future in [future for future in futures if future.done()]:
                watch.ended(_end(future, futures.pop(future), jobs))
            watch.look(min(at_once, len(futures)))
            time.sleep(LOOK_S)
        if futures:
            stop.set()
            client.cancel([future for future in futures if future.status == "pending"])
            distributed.wait([future for future in futures if not future.cancelled()], timeout=GRACE_S)


def _client(distributed: Any, stack: contextlib.ExitStack, address: str, at_once: int) -> Any:
    try:
        with _deaf_children():
            cluster = address or stack.enter_context(
                distributed.LocalCluster(n_workers=at_once, threads_per_worker=1, dashboard_address=None))
        return stack.enter_context(distributed.Client(cluster, timeout="10s"))
    except OSError as error:
        raise UsageError(f"--engine dask: no Dask scheduler at {address}: {error}") from None


def _travelling(distributed: Any, stop_name: str) -> Any:
    """run_job as a function that travels as code: a worker on another machine does not have this package."""
    import cloudpickle

    cloudpickle.register_pickle_by_value(worker)
    run_job = worker.run_job
    # a function without a name in a module is never sent as the name alone
    return lambda *words: run_job(*words, distributed.Event(stop_name).is_set)


def _end(future: Any, index: int, jobs: Sequence[Job]) -> JobEnd:
    if future.status != "finished":
        reason = future.exception() if future.status == "error" else ""
        return JobEnd(index, PROCESS_FAILED, f"{jobs[index].name}: Dask: {future.status}: {reason}", 0.0)
    result: Dict[str, Any] = future.result()
    folder = jobs[index].folder
    write_text(folder / "run.log", result["log"])
    if result["report"] is not None:
        write_text(folder / "report.json", result["report"])
    failure = f"{jobs[index].name}: {result['failure']}" if result["failure"] else ""
    return JobEnd(index, result["status"], failure, result["wall_s"])


@contextlib.contextmanager
def _words_to(file: pathlib.Path) -> Iterator[None]:
    """What Dask and its workers say goes to a file; the terminal keeps the line that tells how far the runs are."""
    with file.open("w", encoding="utf-8") as log, open(os.dup(STDERR), "w", encoding="utf-8") as terminal:
        os.dup2(log.fileno(), STDERR)
        try:
            with contextlib.redirect_stderr(terminal):
                yield
        finally:
            os.dup2(terminal.fileno(), STDERR)


@contextlib.contextmanager
def _deaf_children() -> Iterator[None]:
    """Threads that begin meanwhile, and the processes that they start, do not hear Ctrl-C: they are ended in order.

    Blocked, not ignored: what comes meanwhile is heard afterwards.
    """
    heard = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, heard)
