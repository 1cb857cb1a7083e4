"""Runs of scenarios, as frames."""

from __future__ import annotations

import os
import pathlib
import shutil
import subprocess
import tempfile
from typing import TYPE_CHECKING, Any, List, Mapping, Optional, Union

if TYPE_CHECKING:
    from .log import Recording

USAGE = 2  # exit status of the program for a mistake in the call, 3 and more where something failed


def run(scenario: Union[str, "os.PathLike[str]"], *, seed: int = 1, duration: Optional[float] = None,
        settings: Optional[Mapping[str, Any]] = None, out: Optional[Union[str, "os.PathLike[str]"]] = None,
        program: Optional[str] = None) -> "Recording":
    """Runs a scenario in simulated time, as `c3rt run --in-process`: the same samples and log_hash as with four processes.

    scenario: a name or a file; settings: {"planner.rate_hz": 50} overrides keys of it; duration: ends it after so many seconds;
    out: folder that keeps run.mcap and report.json, else nothing is kept. Returns the recording: frames by topic, and
    `report`, whose "result" is "passed" or says what was not. The program is the argument, C3RT_PROGRAM, or c3rt of the PATH.
    Needs pandas (pip install './python[log]'). ValueError says what is wrong with scenario or settings, RuntimeError what
    failed, FileNotFoundError that there is no program.
    """
    from .log import read

    found = program or os.environ.get("C3RT_PROGRAM") or shutil.which("c3rt")
    if not found:
        raise FileNotFoundError("c3rt.run: there is no program c3rt: build or install it, or name it with C3RT_PROGRAM")
    if isinstance(seed, bool) or not isinstance(seed, int):
        raise TypeError(f"seed: expected a whole number, got {seed!r}")
    words: List[str] = [found, "run", os.fspath(scenario), "--in-process", "--no-pictures", "--seed", str(seed)]
    if duration is not None:
        words += ["--duration", repr(float(duration))]
    for key, value in (settings or {}).items():
        words += ["--set", f"{key}={_yaml(value)}"]
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(out) if out is not None else pathlib.Path(scratch) / "run"
        done = subprocess.run([*words, "--out", os.fspath(folder)], capture_output=True, text=True)
        if done.returncode >= USAGE or done.returncode < 0:
            complaint = done.stderr.strip().removeprefix("c3rt: error: ") or f"{found} ended with status {done.returncode}"
            raise (ValueError if done.returncode == USAGE else RuntimeError)(complaint)
        return read(folder / "run.mcap")


def _yaml(value: Any) -> str:
    if value is None:
        return "~"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_yaml(element) for element in value) + "]"
    return str(value)
