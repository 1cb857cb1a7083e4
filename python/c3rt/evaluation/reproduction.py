"""What every table and figure of `c3rt reproduce` has: settings, runs, results."""

from __future__ import annotations

import dataclasses
import json
import pathlib
from dataclasses import dataclass
from typing import Any, Dict, List, Sequence

from .engine import Stop
from .files import make_folder, write_text
from .groups import Group, make_groups
from .runs import EngineSettings, RunResult
from .status import tell
from .text_table import Rows, text_table

QUICK_RUN_S = 6.0


@dataclass(frozen=True)
class Settings(EngineSettings):
    what: str = ""
    out: str = ""  # folder; empty: out/reproduce
    quick: bool = False  # short runs: for a look, not for numbers
    seeds: str = "1..5"


class Reproduction:
    def __init__(self, settings: Settings, stop: Stop) -> None:
        """UsageError if the folder cannot be made."""
        self.settings = settings
        self._stop = stop
        self._out = make_folder(pathlib.Path(settings.out or "out/reproduce"))

    def groups(self, groups: Sequence[Group]) -> List[List[RunResult]]:
        """The runs of each group, in runs/WHAT-NAME; short where a quick look is wanted."""
        what, quick = self.settings.what, QUICK_RUN_S if self.settings.quick else None
        named = [dataclasses.replace(group, name=f"{what}-{group.name}", duration=quick) for group in groups]
        return make_groups(named, self.settings, self._out / "runs", what, self._stop)

    def finish(self, results: Dict[str, Any]) -> None:
        """Writes WHAT.json and says where it is."""
        file = self._out / f"{self.settings.what}.json"
        write_text(file, json.dumps(results, indent=1, ensure_ascii=False) + "\n")
        tell(f"\n{file}")


def tell_table(heading: str, rows: Rows) -> None:
    tell(f"{heading}\n\n{text_table(rows)}".rstrip("\n"))
