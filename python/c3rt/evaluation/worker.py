"""One run on a worker of Dask. The worker does not need this package: the module travels with the job."""

import contextlib
import ctypes
import hashlib
import os
import pathlib
import signal
import subprocess
import tempfile
import time

PROCESS_FAILED = 3
PR_SET_PDEATHSIG = 1
TAIL_LINES = 15


def hashes(program, names):
    """Of the programs beside this one."""
    folder = pathlib.Path(program).parent
    return {name: hashlib.sha256((folder / name).read_bytes()).hexdigest() for name in names}


def end_with_worker():
    """A run must not outlive the worker that started it, and Ctrl-C on its terminal is not meant for it."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGTERM)
    os.setpgid(0, 0)


def run_job(program, programs_sha256, words, scenario_name, scenario_text, stopped):
    """Makes the run in a folder of its own. Returns {"status", "wall_s", "report" (text or None), "log", "failure"}.

    The program is C3RT_PROGRAM of the worker, else that of the machine that asks; stopped() says whether it is to end.
    """
    result = {"status": PROCESS_FAILED, "wall_s": 0.0, "report": None, "log": "", "failure": ""}
    program = os.environ.get("C3RT_PROGRAM", program)
    try:
        here = hashes(program, programs_sha256)
    except OSError as error:
        return {**result, "failure": f"worker {os.uname().nodename}: no c3rt there: {error}"}
    other = sorted(name for name, value in here.items() if value != programs_sha256[name])
    if other:
        return {**result, "failure": f"worker {os.uname().nodename}: another build of {', '.join(other)}"}
    with tempfile.TemporaryDirectory(prefix="c3rt-run-") as folder:
        scenario = pathlib.Path(folder, scenario_name)
        scenario.write_text(scenario_text, encoding="utf-8")
        log = pathlib.Path(folder, "run.log")
        began = time.monotonic()
        with log.open("w") as output:
            process = subprocess.Popen(
                [program, "run", str(scenario), *words, f"--out={folder}"],
                stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT, preexec_fn=end_with_worker)
            while process.poll() is None:
                with contextlib.suppress(subprocess.TimeoutExpired):
                    process.wait(1.0)
                if process.returncode is None and stopped():
                    process.terminate()
                    process.wait()
                    return {**result, "failure": "stopped"}
        result["wall_s"] = time.monotonic() - began
        result["log"] = log.read_text(encoding="utf-8", errors="replace")
        report = pathlib.Path(folder, "report.json")
        if process.returncode in (0, 1) and report.is_file():
            result["status"] = process.returncode
            result["report"] = report.read_text(encoding="utf-8")
        else:
            tail = "\n".join(result["log"].splitlines()[-TAIL_LINES:])
            result["failure"] = f"c3rt run ended with status {process.returncode}; the end of its log:\n{tail}"
    return result
