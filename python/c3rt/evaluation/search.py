"""What `c3rt tune` looks for: keys of a scenario, each with a range, seen as numbers in [0, 1]."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any, List, Optional, Sequence, Set

from .status import UsageError

LINEAR, LOG, WHOLE = "--linear", "--log", "--whole"  # the options that give them
NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")


@dataclass(frozen=True)
class Parameter:
    """One number of the search. Several keys may share it."""

    keys: List[str]  # "planner.weights.roll.Q.ball_xy"
    scale: str  # LINEAR, LOG or WHOLE
    low: float  # in the keys' units
    high: float


def read_number(text: str) -> Optional[float]:
    """None where the text is no finite number."""
    value = float(text) if NUMBER.fullmatch(text) else math.nan
    return value if math.isfinite(value) else None


def parse_parameter(scale: str, text: str) -> Parameter:
    """Of "planner.admm.rho=0.1..10", "a.b,a.c=1..100". UsageError says what was expected."""
    keys, _, ends = text.partition("=")
    low_text, dots, high_text = ends.partition("..")
    low, high = read_number(low_text), read_number(high_text)
    names = keys.split(",")
    if not dots or low is None or high is None or not all(names):
        raise UsageError(f"{scale}: expected KEY=LOW..HIGH, for example planner.admm.rho=0.1..10, got {text}")
    if low >= high:
        raise UsageError(f"{scale}: expected the lower end before the higher one, got {text}")
    if scale == LOG and low <= 0.0:
        raise UsageError(f"--log: expected a range above 0, got {text}")
    if scale == WHOLE and not (low.is_integer() and high.is_integer()):
        raise UsageError(f"--whole: expected whole numbers, got {text}")
    return Parameter(names, scale, low, high)


def _raised(parameter: Parameter, value: float) -> float:
    return math.log(value) if parameter.scale == LOG else value


def to_unit(parameter: Parameter, value: float) -> float:
    """A value's place in the range."""
    low, high = _raised(parameter, parameter.low), _raised(parameter, parameter.high)
    return (_raised(parameter, value) - low) / (high - low)


def from_unit(parameter: Parameter, unit: float) -> float:
    """And back. A whole number is the nearest."""
    low, high = _raised(parameter, parameter.low), _raised(parameter, parameter.high)
    at = low + min(max(unit, 0.0), 1.0) * (high - low)
    if parameter.scale == LOG:
        return min(max(math.exp(at), parameter.low), parameter.high)
    return _nearest(at) if parameter.scale == WHOLE else at


def _nearest(value: float) -> float:
    """Halves away from zero."""
    whole = float(math.trunc(value))
    return whole + math.copysign(1.0, value) if abs(value - whole) >= 0.5 else whole


def value_at(values: Any, path: str) -> Any:
    """What a path such as "plant.objects.0.mass_kg" means in a scenario, or None."""
    for part in path.split("."):
        if isinstance(values, dict):
            values = values.get(part)
        elif isinstance(values, list) and re.fullmatch("[0-9]{1,5}", part) and int(part) < len(values):
            values = values[int(part)]
        else:
            return None
    return values


def content(value: Any) -> str:
    """What a message says that it got."""
    if isinstance(value, str):
        return f'"{value}"'
    return f"a list of {len(value)}" if isinstance(value, list) else "a mapping"


def start(parameters: Sequence[Parameter], values: Any, file: str) -> List[float]:
    """What the scenario has, in [0, 1].

    file: for messages. UsageError for a key that is not there, is no number, differs from the one that shares its parameter
    or lies outside the range, and for a key that is named twice.
    """
    named: Set[str] = set()
    return [to_unit(parameter, _own_value(parameter, values, file, named)) for parameter in parameters]


def _own_value(parameter: Parameter, values: Any, file: str, named: Set[str]) -> float:
    shared: Optional[float] = None
    for key in parameter.keys:
        said = f"{parameter.scale} {key}: "
        if key in named:
            raise UsageError(f"{said}is named twice")
        named.add(key)
        there = value_at(values, key)
        if there is None:
            raise UsageError(f"{said}no such key in {file}")
        value = read_number(there) if isinstance(there, str) else None
        if value is None:
            raise UsageError(f"{said}expected a number in {file}, got {content(there)}")
        if not parameter.low <= value <= parameter.high:
            raise UsageError(f"{said}expected the scenario's own value in {parameter.low:g} to {parameter.high:g}, got "
                             f"{value:g} (--set gives another start)")
        if shared is not None and value != shared:
            raise UsageError(f"{said}expected the value of {parameter.keys[0]}, {shared:g}, got {value:g}: keys that share a "
                             "number begin with the same")
        shared = value
    assert shared is not None
    return shared


def assignments(parameters: Sequence[Parameter], unit: Sequence[float]) -> List[str]:
    """For --set, with six digits, as a person would write them: "planner.admm.rho=0.316228"."""
    return [f"{key}={from_unit(parameter, at):.6g}" for parameter, at in zip(parameters, unit) for key in parameter.keys]
