"""Groups of runs, each one scenario with one seed or several; those that `c3rt reproduce` asks for."""

from __future__ import annotations

import pathlib
from dataclasses import dataclass, field
from typing import Iterator, List, Optional, Sequence

from .engine import Stop
from .files import make_folder
from .runs import EngineSettings, RunResult, RunSpec, run_all, run_settings
from .seeds import parse_seeds
from .status import say


class Interrupted(Exception):
    """A person wants this to end."""


@dataclass(frozen=True)
class Group:
    name: str  # of its folder; of several seeds NAME-0007
    scenario: str  # name or path
    seeds: str = ""  # parse_seeds(); empty: the first alone
    overrides: List[str] = field(default_factory=list)
    duration: Optional[float] = None  # [s]; None: the scenario's
    logs: bool = False
    in_process: bool = False
    options: List[str] = field(default_factory=list)  # of c3rt run

    def specs(self) -> Iterator[RunSpec]:
        for seed in parse_seeds(self.seeds) if self.seeds else [1]:
            name = f"{self.name}-{seed:04}" if self.seeds else self.name
            yield RunSpec(name, self.scenario, seed, self.overrides, self.duration, self.logs, in_process=self.in_process,
                          options=self.options)


def make_groups(groups: Sequence[Group], settings: EngineSettings, folder: pathlib.Path, title: str,
                stop: Stop) -> List[List[RunResult]]:
    """The runs of each group, each with its own folder below the one given; those of an earlier call are kept.

    title: on the line that tells how far it is. Interrupted where a stop was wanted, RuntimeError where a run has no report.
    """
    specs = [list(group.specs()) for group in groups]
    flat = [spec for several in specs for spec in several]
    results = run_all(flat, run_settings(settings, stop), make_folder(folder), title)
    if len(results) < len(flat):
        raise Interrupted
    for result in results:
        if result.kept:
            say(f"{result.spec.name}: kept from an earlier run ({result.folder})")
        if result.report is None:
            raise RuntimeError(result.failure)
    rest = iter(results)
    return [[next(rest) for _ in several] for several in specs]
