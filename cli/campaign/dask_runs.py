"""Hands runs of a campaign to Dask: each is one call of `c3rt run` on a worker, and its report.json comes back.

Called by `c3rt campaign --engine dask` with a file of jobs:
  {"program": PATH, "programs_sha256": {NAME: HASH}, "address": "" or "tcp://host:port", "at_once": N,
   "scenarios": {SCENARIO_FILE: TEXT},
   "jobs": [{"words": [SCENARIO_FILE, "--seed=7", ...], "folder": DIR}, ...]}
A finished job leaves DIR/report.json, DIR/run.log and, last, DIR/end.json: {"status", "wall_s", "failure"}.
A worker needs c3rt at the same path, or at the path in its C3RT_PROGRAM; the scenario's text travels with the job.
"""

import contextlib
import ctypes
import hashlib
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
import uuid

try:
    import distributed
except ImportError as error:
    print(f"{error}: install Dask (Debian: python3-distributed; pip: distributed)", file=sys.stderr)
    sys.exit(2)

PROCESS_FAILED = 3
PR_SET_PDEATHSIG = 1


def hashes(program, names):
    folder = pathlib.Path(program).parent
    return {name: hashlib.sha256((folder / name).read_bytes()).hexdigest() for name in names}


def end_with_parent():
    """A run must not outlive the worker that started it."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGTERM)


def run_job(program, programs_sha256, words, scenario_name, scenario_text, stop_name):
    """On the worker. Returns {"status", "wall_s", "report" (text or None), "log", "failure"}."""
    result = {"status": PROCESS_FAILED, "wall_s": 0.0, "report": None, "log": "", "failure": ""}
    program = os.environ.get("C3RT_PROGRAM", program)
    try:
        here = hashes(program, programs_sha256)
    except OSError as error:
        return {**result, "failure": f"worker {os.uname().nodename}: no c3rt there: {error}"}
    other = sorted(name for name, value in here.items() if value != programs_sha256[name])
    if other:
        return {**result, "failure": f"worker {os.uname().nodename}: another build of {', '.join(other)}"}
    stop = distributed.Event(stop_name)
    with tempfile.TemporaryDirectory(prefix="c3rt-run-") as folder:
        scenario = pathlib.Path(folder, scenario_name)
        scenario.write_text(scenario_text)
        log = pathlib.Path(folder, "run.log")
        began = time.monotonic()
        with log.open("w") as output:
            process = subprocess.Popen(
                [program, "run", str(scenario), *words, f"--out={folder}"],
                stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT, preexec_fn=end_with_parent)
            while process.poll() is None:
                with contextlib.suppress(subprocess.TimeoutExpired):
                    process.wait(1.0)
                if process.returncode is None and stop.is_set():
                    process.terminate()
                    process.wait()
                    return {**result, "failure": "stopped"}
        result["wall_s"] = time.monotonic() - began
        result["log"] = log.read_text(errors="replace")
        report = pathlib.Path(folder, "report.json")
        if process.returncode in (0, 1) and report.is_file():
            result["status"] = process.returncode
            result["report"] = report.read_text()
        else:
            tail = "\n".join(result["log"].splitlines()[-15:])
            result["failure"] = f"c3rt run ended with status {process.returncode}; the end of its log:\n{tail}"
    return result


def keep(folder, result):
    """end.json comes last and at once: who sees it sees all."""
    folder = pathlib.Path(folder)
    (folder / "run.log").write_text(result["log"])
    if result["report"] is not None:
        (folder / "report.json.part").write_text(result["report"])
        (folder / "report.json.part").replace(folder / "report.json")
    end = {name: result[name] for name in ("status", "wall_s", "failure")}
    (folder / "end.json.part").write_text(json.dumps(end))
    (folder / "end.json.part").replace(folder / "end.json")


def main():
    order = json.loads(pathlib.Path(sys.argv[1]).read_text())
    stopped = threading.Event()
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: stopped.set())
    with contextlib.ExitStack() as stack:
        if order["address"]:
            cluster = order["address"]
        else:
            cluster = stack.enter_context(distributed.LocalCluster(
                n_workers=order["at_once"], threads_per_worker=1, dashboard_address=None))
        try:
            client = stack.enter_context(distributed.Client(cluster, timeout="10s"))
        except OSError as error:
            print(f"no Dask scheduler at {order['address']}: {error}", file=sys.stderr)
            return 2
        stop_name = f"c3rt-stop-{uuid.uuid4()}"
        stop = distributed.Event(stop_name)
        folders = {}
        for job in order["jobs"]:
            scenario = pathlib.Path(job["words"][0])
            future = client.submit(
                run_job, order["program"], order["programs_sha256"], job["words"][1:], scenario.name,
                order["scenarios"][job["words"][0]], stop_name, pure=False)
            folders[future] = job["folder"]
        while folders and not stopped.is_set():
            for future in [future for future in folders if future.done()]:
                folder = folders.pop(future)
                if future.status == "finished":
                    keep(folder, future.result())
                else:
                    failure = f"Dask: {future.status}: {future.exception() if future.status == 'error' else ''}"
                    keep(folder, {"status": PROCESS_FAILED, "wall_s": 0.0, "report": None, "log": "",
                                  "failure": failure})
            stopped.wait(0.2)
        if folders:
            stop.set()
            client.cancel([future for future in folders if future.status == "pending"])
            distributed.wait([future for future in folders if not future.cancelled()], timeout=20)
    return 0


if __name__ == "__main__":
    sys.exit(main())
