"""Runs of scenarios in lockstep, several at once, kept from call to call."""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import json
import os
import pathlib
from dataclasses import dataclass, field
from typing import Any, Dict, List, Optional, Sequence

from .engine import Engine, Job, JobEnd, Stop, Watch, cores, run_here
from .files import hash_of, hash_of_files, make_folder, read_bytes, write_text
from .progress import Progress
from .scenario import Scenario, read_scenario
from .status import CRITERION_FAILED, DONE, PROCESS_FAILED, UsageError
from .text_table import shortest

SHELL_WORDS = set(" []{}*?'\"$&;|<>()#\\")  # what a shell would take apart


@dataclass(frozen=True)
class RunSpec:
    """What one run depends on, beside the programs."""

    name: str  # of its folder and on the screen: "seed-0007"
    scenario: str  # name or path
    seed: int = 1
    overrides: List[str] = field(default_factory=list)  # "planner.rate_hz=75"
    duration: Optional[float] = None  # [s]; None: the scenario's
    logs: bool = False  # run.mcap, too
    pictures: bool = False
    in_process: bool = False  # in one process, without DDS; else with four processes
    options: List[str] = field(default_factory=list)  # of c3rt run, what else there is: "--exact=15"
    is_example: bool = False  # a numerical example; run_all fills it in


@dataclass
class RunResult:
    spec: RunSpec
    folder: pathlib.Path
    status: int = DONE  # what c3rt run exited with: DONE, CRITERION_FAILED or PROCESS_FAILED
    kept: bool = False  # from an earlier call
    wall_s: float = 0.0  # how long it took when it was made
    report: Optional[Dict[str, Any]] = None  # None for PROCESS_FAILED
    failure: str = ""  # what failed, with the end of its log


@dataclass(frozen=True)
class EngineSettings:
    """How runs are made, as a person says it: the same words for every command that makes many."""

    program: str  # c3rt, with the processes beside it
    duration: Optional[float] = None  # of each run [s]; None: the scenario's
    at_once: int = 0  # runs; 0: as many as there are cores
    fresh: bool = False  # makes every run anew
    engine: str = "local"  # or "dask"
    address: str = ""  # of Dask's scheduler; empty: a cluster of its own on this machine


@dataclass(frozen=True)
class RunSettings:
    program: str
    at_once: int
    fresh: bool
    engine: Engine
    stop: Stop


def run_settings(settings: EngineSettings, stop: Stop) -> RunSettings:
    """UsageError for an address without Dask."""
    engine: Engine = functools.partial(run_here, settings.program)
    if settings.engine == "dask":
        from .dask_engine import run_on_dask

        engine = functools.partial(run_on_dask, settings.program, settings.address)
    elif settings.address:
        raise UsageError("--address: only with --engine dask")
    return RunSettings(settings.program, settings.at_once or cores(), settings.fresh, engine, stop)


@dataclass
class _Plan:
    result: RunResult
    key: Dict[str, Any]
    job: Job


def run_all(specs: Sequence[RunSpec], settings: RunSettings, folder: pathlib.Path, title: str) -> List[RunResult]:
    """One result for each spec, in their order; each run has its own folder below the one given.

    A run is made again unless its folder holds one that ended by itself, of the same scenario text, files that it names,
    overrides, seed, duration and programs. title: on the line that tells how far it is. UsageError before anything is started.
    Returns fewer results if a stop was wanted; what was finished is kept for the next call.
    """
    plans = _plans(specs, settings.program, folder)
    have = [not settings.fresh and _take_kept(plan) for plan in plans]
    missing = [index for index, there in enumerate(have) if not there]
    for index in missing:
        _clear(make_folder(plans[index].result.folder))
    if missing:
        line = _Line(title, len(plans), len(plans) - len(missing))

        def ended(end: JobEnd) -> None:
            plan = plans[missing[end.job]]
            _finish(plan, end)
            have[missing[end.job]] = True
            line.ended(plan.result)

        with contextlib.closing(line):
            settings.engine([plans[index].job for index in missing], settings.at_once,
                            Watch(settings.stop, ended, line.look))
    return [plan.result for plan, there in zip(plans, have) if there]


def replay_command(spec: RunSpec) -> str:
    """The same run again, with logs and pictures: "c3rt run circle_slow --clock lockstep --seed 7 --set planner.rate_hz=75"."""
    how = "" if spec.is_example else " --in-process" if spec.in_process else " --clock lockstep"
    text = f"c3rt run {spec.scenario}{how} --seed {spec.seed}"
    if spec.duration is not None:
        text += f" --duration {shortest(spec.duration)}"
    text += "".join(f" {option.replace('=', ' ', 1)}" for option in spec.options)
    for assignment in spec.overrides:
        text += f" --set {assignment}" if SHELL_WORDS.isdisjoint(assignment) else f" --set '{assignment}'"
    return text


def _plans(specs: Sequence[RunSpec], program: str, folder: pathlib.Path) -> List[_Plan]:
    programs = hash_of_programs(program)

    @functools.lru_cache(maxsize=None)
    def read(scenario: str, *overrides: str) -> Scenario:
        return read_scenario(program, scenario, overrides)

    @functools.lru_cache(maxsize=None)
    def hash_of_named(*files: str) -> str:
        return hash_of_files(files)

    plans: List[_Plan] = []
    for spec in specs:
        spec = dataclasses.replace(spec, is_example=read(spec.scenario, *spec.overrides).is_example)
        if spec.is_example and spec.in_process:
            raise UsageError(f"--in-process: {spec.scenario} is a numerical example, which runs in one process anyway")
        # with all that is set, so that a mistake ends the call before the first run
        scenario = read(spec.scenario, *_overrides(spec))
        key = {
            "scenario": hash_of(scenario.own_text.encode()), "files": hash_of_named(*scenario.files),
            "overrides": _overrides(spec), "seed": spec.seed, "logs": spec.logs, "pictures": spec.pictures,
            "in_process": spec.in_process, "options": spec.options, "programs": programs,
        }
        place = folder.absolute() / spec.name
        job = Job(spec.name, scenario.file, scenario.own_text, _words(spec), place)
        plans.append(_Plan(RunResult(spec, place), key, job))
    return plans


def _overrides(spec: RunSpec) -> List[str]:
    if spec.duration is None:
        return spec.overrides
    key = "control.duration_s" if spec.is_example else "task.duration_s"
    return [*spec.overrides, f"{key}={shortest(spec.duration)}"]


def _words(spec: RunSpec) -> List[str]:
    """After "c3rt run SCENARIO"."""
    words = [f"--seed={spec.seed}"]
    if not spec.is_example:
        words += ["--in-process"] if spec.in_process else ["--clock=lockstep", "--domain=any"]
        words += [] if spec.logs else ["--no-logs"]
        words += [] if spec.pictures else ["--no-pictures"]
    return words + spec.options + [f"--set={assignment}" for assignment in _overrides(spec)]


def hash_of_programs(program: str) -> str:
    """What the programs are: another build may answer otherwise though its version is the same."""
    processes = pathlib.Path(os.environ.get("C3RT_PROCESS_DIRECTORY") or pathlib.Path(program).parent)
    files = [pathlib.Path(program)] + [processes / f"c3rt-{name}" for name in ("plant", "impedance", "planner", "vision")]
    return hash_of("".join(hash_of(read_bytes(file)) for file in files).encode())


def read_json(file: pathlib.Path) -> Dict[str, Any]:
    """An object of JSON; an empty one where there is none."""
    with contextlib.suppress(ValueError):
        value = json.loads(read_bytes(file))
        return value if isinstance(value, dict) else {}
    return {}


def _take_kept(plan: _Plan) -> bool:
    """Takes the run of an earlier call where it is the same."""
    result = plan.result
    note, report = read_json(result.folder / "run.json"), read_json(result.folder / "report.json")
    if note.get("key") != plan.key or not report:
        return False
    result.status, result.wall_s, result.report, result.kept = note["status"], note["wall_s"], report, True
    return True


def _clear(folder: pathlib.Path) -> None:
    for name in ("run.json", "report.json"):
        with contextlib.suppress(FileNotFoundError):
            (folder / name).unlink()


def _finish(plan: _Plan, end: JobEnd) -> None:
    """Takes what an ended job left."""
    result = plan.result
    result.status, result.wall_s, result.failure = end.status, end.wall_s, end.failure
    if end.status not in (DONE, CRITERION_FAILED):
        result.status = PROCESS_FAILED
        return
    report = read_json(result.folder / "report.json")
    if not report:
        result.status, result.failure = PROCESS_FAILED, f"{plan.job.name}: no report.json in {result.folder}"
    elif report.get("result") == "interrupted":
        # somebody ended this run alone: it is not what the seed gives
        result.status, result.failure = PROCESS_FAILED, f"{plan.job.name} was interrupted by a signal"
    else:
        result.report = report
        note = {"key": plan.key, "status": end.status, "wall_s": end.wall_s}
        write_text(result.folder / "run.json", json.dumps(note, indent=1, ensure_ascii=False) + "\n")


class _Line:
    """The line on the screen."""

    def __init__(self, title: str, count: int, kept: int) -> None:
        self._progress = Progress(title)
        self._count, self._done = count, kept
        self._made = self._failed = self._missed = 0

    def ended(self, result: RunResult) -> None:
        self._done += 1
        self._made += 1
        self._failed += result.status == PROCESS_FAILED
        self._missed += result.status == CRITERION_FAILED

    def look(self, running: int) -> None:
        # a running job counts for half: nobody knows how far it is
        left = max(0.5, self._count - self._done - 0.5 * running)
        share = self._made / (self._made + left) if self._made else 0.0
        self._progress.update(share, f"{self._done} of {self._count} done, {running} running, {self._missed} missed criteria, "
                                     f"{self._failed} failed")

    def close(self) -> None:
        self._progress.close()
