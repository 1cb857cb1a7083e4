"""What may stand in the description of a figure; the package's words are in its __init__.py."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np

# Okabe and Ito: told apart by who sees no red or no green. https://jfly.uni-koeln.de/color/
PALETTE = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000", "#7f7f7f")
COLOR = re.compile(r"#[0-9a-fA-F]{6}")

Array = np.ndarray
Limits = Tuple[Optional[float], Optional[float]]


class DescriptionError(ValueError):
    """What is wrong with a description, by its key: panels[0].curves[2].color."""


@dataclass(frozen=True)
class Curve:
    name: str
    color: str
    x: Array
    y: Array
    line: str
    marks: str
    width: float
    mark_size: float
    turn: int  # how often the palette was used up before it


@dataclass(frozen=True)
class Shade:
    name: str
    color: str
    low: float
    high: float
    intervals: List[Tuple[float, float]]


@dataclass(frozen=True)
class Band:
    name: str
    color: str
    x: Array
    y: Array
    radius: float


@dataclass(frozen=True)
class Bars:
    name: str
    color: str
    edges: Array
    heights: Array


@dataclass(frozen=True)
class Polygon:
    name: str
    color: str
    edge: Optional[str]
    x: Array
    y: Array


@dataclass(frozen=True)
class Panel:
    title: str
    x_label: str
    y_label: str
    x_scale: str
    y_scale: str
    x_limits: Limits
    y_limits: Limits
    equal: bool
    axes: bool
    legend: str
    curves: List[Curve]
    shades: List[Shade]
    bands: List[Band]
    bars: List[Bars]
    polygons: List[Polygon]


@dataclass(frozen=True)
class Figure:
    title: str
    size: Optional[Tuple[int, int]]  # [pixels]
    columns: int
    panels: List[Panel]


class Entry:
    """One dict of the description: each key is taken once, and none may be left."""

    def __init__(self, value: Any, path: str) -> None:
        if not isinstance(value, Mapping):
            raise DescriptionError(f"{path or 'the figure'}: expected a dict, got {_shown(value)}")
        self._left: Dict[str, Any] = dict(value)
        self._path = path
        self._known: List[str] = []

    def take(self, key: str, read: Callable[[Any, str], Any], **absent: Any) -> Any:
        """What `read` makes of the key's value; absent=…: of a key that is not there."""
        self._known.append(key)
        if key in self._left:
            return read(self._left.pop(key), self._at(key))
        if absent:
            return absent["absent"]
        raise DescriptionError(f"{self._at(key)}: missing")

    def has(self, key: str) -> bool:
        return key in self._left

    def end(self) -> None:
        for key in self._left:
            raise DescriptionError(f"{self._at(str(key))}: unknown key, expected one of {', '.join(self._known)}")

    def equally_long(self, key: str, one: Array, other: Array, more: int = 0) -> None:
        if len(one) != len(other) + more:
            raise DescriptionError(f"{self._at(key)}: expected {len(other) + more} numbers, got {len(one)}")

    def _at(self, key: str) -> str:
        return f"{self._path}.{key}" if self._path else key


def figure_of(description: Any) -> Figure:
    """Reads a description. Raises DescriptionError."""
    entry = Entry(description, "")
    figure = Figure(
        entry.take("title", _text, absent=""),
        entry.take("size", _size, absent=None),
        entry.take("columns", _count, absent=1),
        entry.take("panels", _list_of(_panel)),
    )
    entry.end()
    if not figure.panels:
        raise DescriptionError("panels: expected at least one")
    return figure


def _panel(value: Any, path: str, _: int) -> Panel:
    entry = Entry(value, path)
    panel = Panel(
        entry.take("title", _text, absent=""),
        entry.take("x_label", _text, absent=""),
        entry.take("y_label", _text, absent=""),
        entry.take("x_scale", _one_of("linear", "log"), absent="linear"),
        entry.take("y_scale", _one_of("linear", "log"), absent="linear"),
        entry.take("x_limits", _limits, absent=(None, None)),
        entry.take("y_limits", _limits, absent=(None, None)),
        entry.take("equal", _truth, absent=False),
        entry.take("axes", _truth, absent=True),
        entry.take("legend", _one_of("right", "below"), absent="right"),
        entry.take("curves", _list_of(_curve), absent=[]),
        entry.take("shades", _list_of(_shade), absent=[]),
        entry.take("bands", _list_of(_band), absent=[]),
        entry.take("bars", _list_of(_bars), absent=[]),
        entry.take("polygons", _list_of(_polygon), absent=[]),
    )
    entry.end()
    if panel.bands and not panel.equal:
        raise DescriptionError(f"{path}.bands: their radius is one of a panel with equal: true")
    return panel


def _curve(value: Any, path: str, number: int) -> Curve:
    entry = Entry(value, path)
    turn = 0 if entry.has("color") else number // len(PALETTE)
    curve = Curve(
        entry.take("name", _text, absent=""),
        entry.take("color", _color, absent=PALETTE[number % len(PALETTE)]),
        entry.take("x", _numbers),
        entry.take("y", _numbers),
        entry.take("line", _one_of("solid", "dashed", "none"), absent="solid"),
        entry.take("marks", _one_of("none", "dot", "cross"), absent="none"),
        entry.take("width", _positive, absent=1.5),
        entry.take("mark_size", _positive, absent=4.0),
        turn,
    )
    entry.end()
    entry.equally_long("y", curve.y, curve.x)
    return curve


def _shade(value: Any, path: str, _: int) -> Shade:
    entry = Entry(value, path)
    shade = Shade(
        entry.take("name", _text, absent=""),
        entry.take("color", _color),
        entry.take("low", _number, absent=0.0),
        entry.take("high", _number, absent=1.0),
        entry.take("intervals", _list_of(lambda pair, at, _: _pair(pair, at))),
    )
    entry.end()
    return shade


def _band(value: Any, path: str, _: int) -> Band:
    entry = Entry(value, path)
    band = Band(
        entry.take("name", _text, absent=""),
        entry.take("color", _color),
        entry.take("x", _numbers),
        entry.take("y", _numbers),
        entry.take("radius", _positive),
    )
    entry.end()
    entry.equally_long("y", band.y, band.x)
    return band


def _bars(value: Any, path: str, number: int) -> Bars:
    entry = Entry(value, path)
    bars = Bars(
        entry.take("name", _text, absent=""),
        entry.take("color", _color, absent=PALETTE[number % len(PALETTE)]),
        entry.take("edges", _numbers),
        entry.take("heights", _numbers),
    )
    entry.end()
    entry.equally_long("edges", bars.edges, bars.heights, more=1)
    return bars


def _polygon(value: Any, path: str, _: int) -> Polygon:
    entry = Entry(value, path)
    polygon = Polygon(
        entry.take("name", _text, absent=""),
        entry.take("color", _color),
        entry.take("edge", _color, absent=None),
        entry.take("x", _numbers),
        entry.take("y", _numbers),
    )
    entry.end()
    entry.equally_long("y", polygon.y, polygon.x)
    return polygon


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "…"


def _list_of(read: Callable[[Any, str, int], Any]) -> Callable[[Any, str], List[Any]]:
    def read_all(value: Any, path: str) -> List[Any]:
        if not isinstance(value, Sequence) or isinstance(value, (str, bytes)):
            raise DescriptionError(f"{path}: expected a list, got {_shown(value)}")
        return [read(item, f"{path}[{number}]", number) for number, item in enumerate(value)]

    return read_all


def _text(value: Any, path: str) -> str:
    if not isinstance(value, str):
        raise DescriptionError(f"{path}: expected a text, got {_shown(value)}")
    return value


def _color(value: Any, path: str) -> str:
    if not isinstance(value, str) or not COLOR.fullmatch(value):
        raise DescriptionError(f"{path}: expected a colour, #rrggbb, got {_shown(value)}")
    return value


def _truth(value: Any, path: str) -> bool:
    if not isinstance(value, bool):
        raise DescriptionError(f"{path}: expected true or false, got {_shown(value)}")
    return value


def _one_of(*words: str) -> Callable[[Any, str], str]:
    def read(value: Any, path: str) -> str:
        if value not in words:
            raise DescriptionError(f"{path}: expected one of {', '.join(words)}, got {_shown(value)}")
        return str(value)

    return read


def _count(value: Any, path: str) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or value < 1:
        raise DescriptionError(f"{path}: expected a whole number of at least 1, got {_shown(value)}")
    return value


def _number(value: Any, path: str) -> float:
    try:
        number = math.nan if isinstance(value, (str, bool)) else float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number):
        raise DescriptionError(f"{path}: expected a number, got {_shown(value)}")
    return number


def _positive(value: Any, path: str) -> float:
    number = _number(value, path)
    if number <= 0.0:
        raise DescriptionError(f"{path}: expected a number above 0, got {_shown(value)}")
    return number


def _two(value: Any, path: str) -> Sequence[Any]:
    if not isinstance(value, (Sequence, np.ndarray)) or isinstance(value, str) or len(value) != 2:
        raise DescriptionError(f"{path}: expected two numbers, got {_shown(value)}")
    return value


def _pair(value: Any, path: str) -> Tuple[float, float]:
    low, high = (_number(item, path) for item in _two(value, path))
    return low, high


def _limits(value: Any, path: str) -> Limits:
    low, high = (None if item is None else _number(item, path) for item in _two(value, path))
    if low is not None and high is not None and low >= high:
        raise DescriptionError(f"{path}: expected the smaller number first, got {_shown(value)}")
    return low, high


def _size(value: Any, path: str) -> Tuple[int, int]:
    width, height = (_count(item, path) for item in _two(value, path))
    return width, height


def _numbers(value: Any, path: str) -> Array:
    """Numbers; nan where there is none."""
    if isinstance(value, str) or not hasattr(value, "__len__"):
        raise DescriptionError(f"{path}: expected a list of numbers, got {_shown(value)}")
    try:
        array = np.asarray(value)
        if array.dtype.kind not in "fiu" and array.size > 0:
            for item in value:
                if item is not None:
                    _number(item, path)
        array = array.astype(float)
    except (TypeError, ValueError) as error:
        if isinstance(error, DescriptionError):
            raise
        raise DescriptionError(f"{path}: expected a list of numbers, got {_shown(value)}") from None
    if array.ndim != 1:
        raise DescriptionError(f"{path}: expected a list of numbers, got one of shape {array.shape}")
    return np.where(np.isfinite(array), array, np.nan)
