"""Scenarios as the program c3rt reads them."""

from __future__ import annotations

import json
import pathlib
import subprocess
from dataclasses import dataclass
from typing import Any, List, Sequence

from .status import USAGE, UsageError


@dataclass(frozen=True)
class Scenario:
    """What `c3rt scenario NAME --set … --json` tells."""

    file: str
    is_example: bool  # a numerical example, not the four processes
    own_text: str  # the scenario with what it extends, without what was set
    text: str  # with it, as YAML that needs no other file
    values: Any  # the same as mappings and lists; each single value as text, None where there is none
    files: List[str]  # that values name, with their paths

    @property
    def name(self) -> str:
        return pathlib.Path(self.file).stem


def read_scenario(program: str, scenario: str, overrides: Sequence[str] = ()) -> Scenario:
    """scenario: a name or a path. UsageError for whatever would keep it from being run."""
    words = [program, "scenario", scenario, "--json", *(f"--set={assignment}" for assignment in overrides)]
    done = subprocess.run(words, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    if done.returncode == 0:
        return Scenario(**json.loads(done.stdout))
    reason = done.stderr.strip().replace("c3rt: error: ", "", 1) or f"{program} ended with status {done.returncode}"
    raise UsageError(reason) if done.returncode == USAGE else RuntimeError(reason)
