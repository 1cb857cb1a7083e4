"""`c3rt tune`: numbers of a scenario, found by CMA-ES over runs, judged on other seeds."""

from __future__ import annotations

import json
import math
import pathlib
from dataclasses import dataclass, field
from typing import Any, Dict, List, Optional, Sequence, Tuple

from .engine import Stop
from .files import make_folder, write_text
from .groups import Interrupted
from .optimiser import Optimiser, usual_population
from .runs import EngineSettings, RunResult, RunSpec, run_all, run_settings
from .scenario import read_scenario
from .score import Score, ranks, score, text
from .search import LINEAR, LOG, WHOLE, Parameter, assignments, parse_parameter, start
from .seeds import parse_seeds
from .statistics import figures
from .status import CRITERION_FAILED, DONE, PROCESS_FAILED, UsageError, complain, say, tell
from .text_table import markdown_table, text_table


@dataclass(frozen=True)
class Settings(EngineSettings):
    scenario: str = ""  # name or path
    overrides: List[str] = field(default_factory=list)  # where it begins: "planner.rate_hz=75"
    search_overrides: List[str] = field(default_factory=list)  # beside these, in the generations alone
    linear: List[str] = field(default_factory=list)  # "planner.admm.rho=0.1..10"
    log: List[str] = field(default_factory=list)
    whole: List[str] = field(default_factory=list)
    minimise: str = ""  # one of them: a figure of report.json
    maximise: str = ""
    seeds: str = "101..104"
    finalists: int = 4  # the best candidates, judged once more on other seeds; 1: the best on the seeds is what is found
    final_seeds: str = "201..210"
    test_seeds: str = "1..10"
    generations: int = 20
    population: int = 0  # 0: usual_population()
    sigma: float = 0.2  # of each range
    seed: int = 1
    out: str = ""  # empty: out/tune-SCENARIO

    @property
    def figure(self) -> str:
        return self.minimise or self.maximise

    @property
    def more_is_better(self) -> bool:
        return not self.minimise


@dataclass(frozen=True)
class Candidate:
    """What was tried, and how good it is."""

    unit: List[float]
    score: Score


def run(settings: Settings, stop: Stop) -> int:
    """Leaves SCENARIO_tuned.yaml, tune.json and tune.md in its folder, and every run.

    The same call goes on where an earlier one was ended. Returns DONE where what was found is at least as good as the start
    on the test seeds, CRITERION_FAILED where it is not, or it was interrupted, PROCESS_FAILED where no run of the start ended
    well. UsageError before anything is started.
    """
    tuner = Tuner(settings, stop)
    try:
        return tuner.run()
    except Interrupted as place:
        say(f"interrupted {place}; the same command goes on from there")
        return CRITERION_FAILED


class Tuner:
    def __init__(self, settings: Settings, stop: Stop) -> None:
        self._settings = settings
        self._how = run_settings(settings, stop)
        self._parameters = _parameters_of(settings)
        if bool(settings.minimise) == bool(settings.maximise):
            raise UsageError("expected --minimise FIGURE or --maximise FIGURE, got both or none")
        if settings.finalists > 1:
            _require_other_seeds("--final-seeds", settings.final_seeds, settings.seeds, "--seeds")
            _require_other_seeds("--test-seeds", settings.test_seeds, settings.final_seeds, "--final-seeds")
        _require_other_seeds("--test-seeds", settings.test_seeds, settings.seeds, "--seeds")
        self._scenario = read_scenario(settings.program, settings.scenario, settings.overrides)
        self._name = self._scenario.name
        mean = start(self._parameters, self._scenario.values, self._scenario.file)
        population = settings.population or usual_population(len(self._parameters))
        self._optimiser = Optimiser(mean, settings.sigma, settings.seed, population)
        self._start = self._best = Candidate(mean, Score())
        self._generations: List[List[Candidate]] = []
        self._finals: List[Tuple[Candidate, Candidate]] = []  # on the seeds, on the final seeds
        self._folder = make_folder(pathlib.Path(settings.out or f"out/tune-{self._name}"))

    def run(self) -> int:
        settings = self._settings
        tell(f"c3rt tune {self._name}: {len(self._parameters)} numbers, {settings.generations} generations of "
             f"{self._optimiser.population}, seeds {settings.seeds}, in {self._folder}")
        self._start = self._best = self._search("start", "at the start", "start-", [self._start.unit])[0]
        if self._start.score.failed > 0:
            return PROCESS_FAILED
        self._tell("start", self._start.score)
        for number in range(1, settings.generations + 1):
            candidates = self._search(f"generation {number} of {settings.generations}", f"in generation {number}",
                                      f"g{number:03}-c", self._optimiser.ask())
            self._take(candidates)
            self._tell(f"generation {number}", self._best.score)
            self._write(None)
        if settings.finalists > 1:
            self._hold_final()
        tested = self._judge("test", "on the test seeds", "test-", [self._start.unit, self._best.unit], settings.test_seeds)
        return self._end(tested[0].score, tested[1].score)

    def _hold_final(self) -> None:
        """Of many that were lucky on a few seeds, the one that is best on others is what is found."""
        every: Dict[Tuple[float, ...], Candidate] = {}
        for candidate in [self._start, *(one for generation in self._generations for one in generation)]:
            every.setdefault(tuple(candidate.unit), candidate)
        finalists = sorted(every.values(), key=lambda candidate: candidate.score)[:self._settings.finalists]
        judged = self._judge("final", "in the final", "final-", [one.unit for one in finalists], self._settings.final_seeds)
        self._finals = list(zip(finalists, judged))
        self._best = min(self._finals, key=lambda both: both[1].score)[0]
        for number, (_, on_final_seeds) in enumerate(self._finals, 1):
            self._tell(f"finalist {number}", on_final_seeds.score)
        self._write(None)

    def _search(self, title: str, place: str, prefix: str, units: Sequence[List[float]]) -> List[Candidate]:
        return self._judge(title, place, prefix, units, self._settings.seeds, self._settings.search_overrides)

    def _judge(self, title: str, place: str, prefix: str, units: Sequence[List[float]], seeds: str,
               more_overrides: Sequence[str] = ()) -> List[Candidate]:
        """Every seed of every candidate, as one set of runs.

        place: where the search is, for Interrupted. prefix: of the runs' folders.
        """
        settings = self._settings
        numbers = parse_seeds(seeds)
        specs = [RunSpec(f"{prefix}{index:02}-seed-{seed:04}", settings.scenario, seed, [*self._overrides(unit), *more_overrides],
                         settings.duration,
                         in_process=not self._scenario.is_example)
                 for index, unit in enumerate(units, 1) for seed in numbers]
        results = run_all(specs, self._how, self._folder, f"tune {self._name}, {title}")
        if len(results) < len(specs):
            raise Interrupted(place)
        self._require_figure(results)
        for result in results:
            if result.status == PROCESS_FAILED:
                complain(result.failure)
        own = [results[first:first + len(numbers)] for first in range(0, len(results), len(numbers))]
        return [Candidate(unit, score(of, settings.figure, settings.more_is_better)) for unit, of in zip(units, own)]

    def _require_figure(self, results: Sequence[RunResult]) -> None:
        """A name that no report has is a mistake; a figure that one run does not reach is none."""
        names: Dict[str, None] = {}  # in the reports' order
        for result in results:
            names.update(dict.fromkeys(figures(result.report)))
        if names and not self._generations and self._settings.figure not in names:
            option = "--maximise" if self._settings.more_is_better else "--minimise"
            raise UsageError(f"{option}: expected a figure of report.json, got {self._settings.figure}; there are "
                             f"{', '.join(names)}")

    def _take(self, candidates: List[Candidate]) -> None:
        self._best = min([self._best, *candidates], key=lambda candidate: candidate.score)
        self._optimiser.tell(ranks([candidate.score for candidate in candidates]))
        self._generations.append(candidates)

    def _overrides(self, unit: Sequence[float]) -> List[str]:
        return [*self._settings.overrides, *assignments(self._parameters, unit)]

    def _text(self, of: Score) -> str:
        return text(of, self._settings.figure, self._settings.more_is_better)

    def _tell(self, what: str, of: Score) -> None:
        tell(f"  {what:<16}{self._text(of)}")

    def _json(self, of: Score) -> Dict[str, Any]:
        value = -of.figure if self._settings.more_is_better else of.figure
        return {"failed": of.failed, "shortfall": of.shortfall, self._settings.figure: value if math.isfinite(value) else None}

    def _write(self, test: Optional[Dict[str, Any]]) -> None:
        settings = self._settings
        told = {
            "scenario": self._name, "overrides": settings.overrides,
            "search_overrides": settings.search_overrides, "seeds": settings.seeds,
            "final_seeds": settings.final_seeds if settings.finalists > 1 else None, "test_seeds": settings.test_seeds,
            "figure": settings.figure, "start": self._json(self._start.score),
            "best": self._json(self._best.score), "best_values": assignments(self._parameters, self._best.unit), "test": test,
            "finals": [{**self._json(on_final_seeds.score), "values": assignments(self._parameters, on_final_seeds.unit)}
                       for _, on_final_seeds in self._finals],
            "generations": [[{**self._json(one.score), "values": assignments(self._parameters, one.unit)} for one in generation]
                            for generation in self._generations],
        }
        write_text(self._folder / "tune.json", json.dumps(told, indent=1, ensure_ascii=False) + "\n")

    def _write_scenario(self) -> pathlib.Path:
        """The scenario whole, with what was found."""
        file = self._folder / f"{self._name}_tuned.yaml"
        overrides = [*self._overrides(self._best.unit), f"name={self._name}_tuned"]
        write_text(file, read_scenario(self._settings.program, self._settings.scenario, overrides).text)
        return file

    def _end(self, start_score: Score, found: Score) -> int:
        settings = self._settings
        file = self._write_scenario()
        is_better = not start_score < found
        self._write({"start": self._json(start_score), "found": self._json(found), "at_least_as_good": is_better})
        rows: List[Sequence[str]] = [
            ("", f"seeds {settings.seeds}", f"test seeds {settings.test_seeds}"),
            ("start", self._text(self._start.score), self._text(start_score)),
            ("found", self._text(self._best.score), self._text(found))]
        if self._finals:
            rows.append((f"finalists, on seeds {settings.seeds} and on final seeds {settings.final_seeds}",))
            rows += [(f"{number}{', found' if one is self._best else ''}", self._text(one.score), self._text(final.score))
                     for number, (one, final) in enumerate(self._finals, 1)]
        values = assignments(self._parameters, self._best.unit)
        listed = "".join(f"- `{value}`\n" for value in values)
        write_text(self._folder / "tune.md", f"# c3rt tune {self._name}\n\n{markdown_table(rows)}\n{listed}")
        tell(f"\n{text_table(rows)}")
        for value in values:
            tell(f"  {value}")
        tell(f"{self._name}: {'no worse' if is_better else 'worse'} than the start on seeds that it was not chosen on\n"
             f"  {'scenario':<16}{file}")
        return DONE if is_better else CRITERION_FAILED


def _parameters_of(settings: Settings) -> List[Parameter]:
    texts = ((LINEAR, settings.linear), (LOG, settings.log), (WHOLE, settings.whole))
    parameters = [parse_parameter(scale, text) for scale, several in texts for text in several]
    if len(parameters) < 2:
        raise UsageError(f"expected two numbers to look for or more (--linear, --log, --whole), got {len(parameters)}: of one, "
                         "c3rt campaign with some values of --set tells as much")
    return parameters


def _require_other_seeds(option: str, seeds: str, used: str, used_by: str) -> None:
    known = set(parse_seeds(used))
    for seed in parse_seeds(seeds):
        if seed in known:
            raise UsageError(f"{option}: expected seeds that are not among {used_by}, got {seed} in both: what was chosen on a "
                             "seed proves nothing there")
