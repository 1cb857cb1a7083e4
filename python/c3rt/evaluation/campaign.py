"""`c3rt campaign`: one scenario, many seeds, one table."""

from __future__ import annotations

import json
import pathlib
from dataclasses import dataclass, field
from typing import Any, Dict, List, Sequence

from .engine import Stop
from .files import make_folder, write_text
from .runs import EngineSettings, RunResult, RunSpec, replay_command, run_all, run_settings
from .scenario import read_scenario
from .seeds import parse_seeds
from .status import CRITERION_FAILED, DONE, PROCESS_FAILED, complain, say, tell
from .summary import Summary, rows, summarise, to_json, verdict
from .text_table import markdown_table, text_table


@dataclass(frozen=True)
class Settings(EngineSettings):
    scenario: str = ""  # name or path
    seeds: str = "1..20"  # parse_seeds()
    overrides: List[str] = field(default_factory=list)  # "planner.rate_hz=75"
    out: str = ""  # empty: out/campaign-SCENARIO
    logs: bool = False
    pictures: bool = False
    in_process: bool = False  # each run in one process


def run(settings: Settings, stop: Stop) -> int:
    """Prints the table and writes campaign.json and campaign.md; each run is in OUT/seed-NNNN.

    Returns an exit status: DONE if every run met its criteria, CRITERION_FAILED if one did not or it was interrupted,
    PROCESS_FAILED if a process failed. UsageError before anything is started.
    """
    how = run_settings(settings, stop)
    specs = [RunSpec(f"seed-{seed:04}", settings.scenario, seed, settings.overrides, settings.duration, settings.logs,
                     settings.pictures, settings.in_process) for seed in parse_seeds(settings.seeds)]
    name = read_scenario(settings.program, settings.scenario, settings.overrides).name
    folder = make_folder(pathlib.Path(settings.out or f"out/campaign-{name}"))
    tell(f"c3rt campaign {name}: {len(specs)} runs, {how.at_once} at once, in {folder}")
    results = run_all(specs, how, folder, f"campaign {settings.scenario}")
    is_complete = len(results) == len(specs)
    _tell_of(results, len(specs))
    if not results:
        return CRITERION_FAILED
    summary = summarise(results)
    _write(folder, name, settings, summary, results, is_complete)
    tell(f"\n{text_table(rows(summary))}\n{name}: {verdict(summary)}")
    tell(f"  {'worst run again':<16}{replay_command(results[summary.worst].spec)}\n  {'results in':<16}{folder}")
    if summary.failed > 0:
        return PROCESS_FAILED
    return DONE if is_complete and summary.missed == 0 else CRITERION_FAILED


def _tell_of(results: Sequence[RunResult], wanted: int) -> None:
    kept = sum(result.kept for result in results)
    if kept > 0:
        tell(f"{kept} runs of an earlier call are kept")
    for result in results:
        if result.status == PROCESS_FAILED:
            complain(result.failure)
    if len(results) < wanted:
        say(f"interrupted after {len(results)} of {wanted} runs; the same command goes on from there")


def _write(folder: pathlib.Path, name: str, settings: Settings, summary: Summary, results: Sequence[RunResult],
           is_complete: bool) -> None:
    told: Dict[str, Any] = {"scenario": name, "seeds": settings.seeds, "overrides": settings.overrides,
                            "complete": is_complete, **to_json(summary, results)}
    write_text(folder / "campaign.json", json.dumps(told, indent=1, ensure_ascii=False) + "\n")
    write_text(folder / "campaign.md", _markdown(settings, summary, results))


def _markdown(settings: Settings, summary: Summary, results: Sequence[RunResult]) -> str:
    text = f"# Campaign {settings.scenario}, seeds {settings.seeds}\n\n"
    if settings.overrides:
        text += "Overrides:" + "".join(f" `{assignment}`" for assignment in settings.overrides) + "\n\n"
    text += f"{verdict(summary)}.\n\n{markdown_table(rows(summary))}\n"
    return text + f"The worst run again: `{replay_command(results[summary.worst].spec)}`\n"
