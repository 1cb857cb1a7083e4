"""What every table and figure of `c3rt reproduce` has: settings, runs, pictures, results."""

from __future__ import annotations

import dataclasses
import json
import pathlib
from dataclasses import dataclass
from typing import Any, Dict, List, Optional, Sequence

from .engine import Stop, run_alone
from .files import hash_of, hash_of_files, make_folder, tail, write_text
from .groups import Group, Interrupted, make_groups
from .runs import EngineSettings, RunResult, hash_of_programs, read_json
from .scenario import read_scenario
from .status import CRITERION_FAILED, DONE, UNDECIDED, say, tell
from .text_table import Rows, text_table

QUICK_RUN_S, QUICK_EXAMPLE_S = 6.0, 0.3
TAIL_LINES = 15


@dataclass(frozen=True)
class Settings(EngineSettings):
    what: str = ""
    out: str = ""  # folder; empty: out/reproduce
    quick: bool = False  # short runs: for a look, not for numbers
    seeds: str = "1..5"  # of comparison and push_anything
    miqp_limit: float = 15.0  # of one monolithic MIQP [s]


@dataclass(frozen=True)
class Example:
    """One trial of a numerical example with seed 1."""

    name: str  # of its folder
    scenario: str
    overrides: Sequence[str] = ()
    options: Sequence[str] = ()  # of c3rt run


class Reproduction:
    def __init__(self, settings: Settings, stop: Stop) -> None:
        """UsageError if the folder cannot be made."""
        self.settings = settings
        self._stop = stop
        self._out = make_folder(pathlib.Path(settings.out or "out/reproduce"))

    def groups(self, groups: Sequence[Group]) -> List[List[RunResult]]:
        """The runs of each group, in runs/WHAT-NAME; short where a quick look is wanted."""
        return self._make(groups, self.settings, QUICK_RUN_S)

    def runs(self, groups: Sequence[Group]) -> List[RunResult]:
        """The one run of each of these."""
        return [runs[0] for runs in self.groups(groups)]

    def examples(self, examples: Sequence[Example]) -> List[RunResult]:
        """One after the other, since their times are measured; short where a quick look is wanted."""
        groups = [Group(example.name, example.scenario, overrides=[*example.overrides, "start.trials=1"],
                        options=list(example.options)) for example in examples]
        one_at_a_time = dataclasses.replace(self.settings, at_once=1)
        return [runs[0] for runs in self._make(groups, one_at_a_time, QUICK_EXAMPLE_S)]

    def _make(self, groups: Sequence[Group], settings: Settings, quick_s: float) -> List[List[RunResult]]:
        what = settings.what
        named = [dataclasses.replace(group, name=f"{what}-{group.name}", duration=quick_s if settings.quick else None)
                 for group in groups]
        return make_groups(named, settings, self._out / "runs", what, self._stop)

    def folder(self, name: str) -> pathlib.Path:
        """Of what is made by this name."""
        return make_folder(self._out / "runs" / f"{self.settings.what}-{name}")

    def call(self, name: str, words: Sequence[str], inputs: Any, answer: str) -> pathlib.Path:
        """The folder of what `c3rt WORDS` answers; kept from an earlier call with the same words, inputs and programs.

        inputs: what else the answer depends on. answer: a file of it. The words have {folder} where the folder stands.
        Interrupted, RuntimeError with the end of the log where there is no answer.
        """
        folder = self.folder(name)
        key = {"words": list(words), "inputs": inputs, "programs": hash_of_programs(self.settings.program)}
        note = folder / "call.json"
        if not self.settings.fresh and (folder / answer).is_file() and read_json(note).get("key") == key:
            say(f"{name}: kept from an earlier run ({folder})")
            return folder
        for file in (note, folder / answer):
            file.unlink(missing_ok=True)
        if self._stop():
            raise Interrupted
        log = folder / "call.log"
        status = run_alone([self.settings.program, *(word.format(folder=folder) for word in words)], log, self._stop)
        if self._stop():
            raise Interrupted
        if status not in (DONE, CRITERION_FAILED, UNDECIDED) or not (folder / answer).is_file():
            raise RuntimeError(f"c3rt {words[0]} ended with status {status}; the end of its log ({log}):\n"
                               f"{tail(log, TAIL_LINES)}")
        write_text(note, json.dumps({"key": key}, indent=1, ensure_ascii=False) + "\n")
        return folder

    def series(self, run: RunResult) -> pathlib.Path:
        """objects.csv, end_effector.csv and path.csv of a run with logs."""
        recording = run.folder / "run.mcap"
        assert run.report is not None
        name = f"{run.folder.name[len(self.settings.what) + 1:]}-series"
        return self.call(name, ["report", str(recording), "--series={folder}"], run.report["log_hash"], "objects.csv")

    def scenario_inputs(self, scenario: str, overrides: Sequence[str] = ()) -> Dict[str, str]:
        """Of call(): what the scenario says, and the files that it names."""
        read = read_scenario(self.settings.program, scenario, overrides)
        return {"scenario": hash_of(read.text.encode()), "files": hash_of_files(read.files)}

    def quick_overrides(self) -> List[str]:
        """Of an example, where a quick look is wanted."""
        return [f"control.duration_s={QUICK_EXAMPLE_S}"] if self.settings.quick else []

    def finish(self, results: Dict[str, Any], figure: Optional[Dict[str, Any]] = None) -> None:
        """Writes WHAT.json and draws WHAT.png, a figure of c3rt.pictures; says where they are."""
        file = self._out / f"{self.settings.what}.json"
        write_text(file, json.dumps(results, indent=1, ensure_ascii=False) + "\n")
        tell(f"\n{file}")
        if figure is not None:
            self._draw(figure, file.with_suffix(".png"))

    @staticmethod
    def _draw(figure: Dict[str, Any], file: pathlib.Path) -> None:
        try:
            from c3rt.pictures import draw
        except ImportError as error:
            say(f"c3rt: {file.name} is missing: {error} (Debian: python3-matplotlib; pip: matplotlib)")
            return
        draw(figure, file)
        tell(str(file))


def tell_table(heading: str, rows: Rows) -> None:
    tell(f"{heading}\n\n{text_table(rows)}".rstrip("\n"))
