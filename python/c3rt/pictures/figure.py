"""Draws what a description says, by matplotlib."""

from __future__ import annotations

import io
import os
import pathlib
from typing import Any, List, Optional, Tuple, Union

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from matplotlib.transforms import ScaledTranslation

from .description import Array, Band, Panel, figure_of
from .description import Figure as Description

DPI = 100
PANEL_WIDTH, PANEL_HEIGHT, TITLE_HEIGHT = 680, 220, 40  # [pixels]
SQUARE = 420  # a panel seen from above [pixels]
MARGIN, LINE_HEIGHT, TICKS_HEIGHT, TICKS_WIDTH = 12, 19, 22, 92  # about a panel [pixels]
TITLE_SIZE, LEGEND_MARK = 12, 5  # [points]
POINTS_PER_INCH = 72.0
NEAR_TICK = 0.02  # of an axis
LEAST_PLAIN, LARGEST_PLAIN = 1e-3, 1e4  # what an axis of powers of ten writes out
INK, GRID = "#202020", "#e4e4e4"
LOOK = {
    "font.family": "DejaVu Sans",
    "font.size": 10.5,
    "axes.titlesize": 11,
    "axes.labelsize": 10.5,
    "axes.titlepad": 7,
    "axes.formatter.limits": (-4, 5),
    "axes.formatter.useoffset": False,
    "legend.fontsize": 9.5,
    "legend.frameon": False,
    "legend.handlelength": 1.8,
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.edgecolor": "#606060",
    "xtick.color": "#404040",
    "ytick.color": "#404040",
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": GRID,
    "grid.linewidth": 0.7,
    "path.simplify": True,
    "agg.path.chunksize": 10000,
}
# of a curve without a colour of its own, by how often the palette was used up before it
MARKS = {"none": ["None"], "dot": ["o", "s", "^", "D"], "cross": ["x"]}
LINES = {"none": ["None"], "solid": ["-", (0, (6, 1.5)), (0, (1, 1)), (0, (6, 1, 1, 1))], "dashed": [(0, (5, 3))]}


def draw(description: Any, path: Union[str, "os.PathLike[str]"]) -> None:
    """Draws a figure as a PNG. The file comes to be whole or not at all.

    Raises DescriptionError, which names the key, and OSError where the file cannot be written.
    """
    said = figure_of(description)
    with matplotlib.rc_context():
        matplotlib.rcdefaults()  # whatever a person's own matplotlibrc says
        matplotlib.rcParams.update(LOOK)
        figure = make(said)
        picture = io.BytesIO()
        figure.savefig(picture, format="png", dpi=DPI)
    _replace(pathlib.Path(path), picture.getvalue())


def _replace(file: pathlib.Path, data: bytes) -> None:
    part = file.with_name(file.name + ".part")
    try:
        part.write_bytes(data)
        part.replace(file)
    except OSError:
        part.unlink(missing_ok=True)
        raise


def make(said: Description) -> Figure:
    figure = Figure(dpi=DPI, facecolor="white")
    FigureCanvasAgg(figure)
    width = said.size[0] / said.columns if said.size else None
    cells = [
        _Cell(figure.add_axes((0.0, 0.0, 1.0, 1.0), label=str(number)), panel, width)
        for number, panel in enumerate(said.panels)
    ]
    rows = [cells[first : first + said.columns] for first in range(0, len(cells), said.columns)]
    top = TITLE_HEIGHT if said.title else MARGIN
    width, height = said.size or _size_of(rows, said.columns, top)
    figure.set_size_inches((width + 0.01) / DPI, (height + 0.01) / DPI)  # matplotlib rounds pixels down
    if said.title:
        y = 1.0 - 0.5 * TITLE_HEIGHT / height
        figure.text(0.5, y, said.title, size=TITLE_SIZE, ha="center", va="center", parse_math=False)
    _place(rows, width, height, said.columns, top)
    for cell in cells:
        cell.axes.apply_aspect()
        for line, band in cell.bands:
            line.set_linewidth(_width_of(cell.axes, band.radius))
    return figure


class _Cell:
    """A panel with what lies about it [pixels]."""

    def __init__(self, axes: Axes, panel: Panel, width: Optional[float]) -> None:
        self.axes = axes
        self.bands, entries = _draw_panel(axes, panel)
        self.top = MARGIN + LINE_HEIGHT * (panel.title.count("\n") + 1 if panel.title else 0)
        self.bottom = MARGIN + TICKS_HEIGHT * panel.axes + (LINE_HEIGHT if panel.x_label else 0)
        self.left = TICKS_WIDTH if panel.axes else MARGIN
        self.right = 2 * MARGIN  # half of an axis' last number
        self.inner = (SQUARE, SQUARE) if panel.equal else (PANEL_WIDTH, PANEL_HEIGHT)
        if entries and panel.legend == "right":
            beside = ScaledTranslation(self.right / DPI, 0.0, axes.figure.dpi_scale_trans)
            where = {"loc": "upper left", "bbox_to_anchor": (1.0, 1.0), "bbox_transform": axes.transAxes + beside}
            legend = _legend(axes, entries, **where).get_window_extent()
            self.right += legend.width
            self.inner = self.inner[0], max(self.inner[1], legend.height)
        elif entries:
            under = ScaledTranslation(0.0, -self.bottom / DPI, axes.figure.dpi_scale_trans)
            width = width or self.left + self.inner[0] + self.right
            room = width - self.left + self.right - 2 * MARGIN  # the legend's middle is that of the axes
            legend = _legend_below(axes, entries, room, bbox_transform=axes.transAxes + under)
            self.bottom += legend.get_window_extent().height + MARGIN


def _size_of(rows: List[List[_Cell]], columns: int, top: float) -> Tuple[int, int]:
    """What gives every panel the room that it wants."""
    cells = [cell for row in rows for cell in row]
    about = max(cell.left for cell in cells) + max(cell.right for cell in cells)
    inner = max(cell.inner[0] for cell in cells), max(cell.inner[1] for cell in cells)
    height = top + len(rows) * inner[1] + sum(_height_about(row) for row in rows)
    return round(columns * (about + inner[0])), round(height)


def _height_about(row: List[_Cell]) -> float:
    return max(cell.top for cell in row) + max(cell.bottom for cell in row)


def _place(rows: List[List[_Cell]], width: float, height: float, columns: int, top: float) -> None:
    """Gives every panel as much room as the others, with their edges one above the other."""
    cells = [cell for row in rows for cell in row]
    left, right = max(cell.left for cell in cells), max(cell.right for cell in cells)
    inner_width = max(width / columns - left - right, 1.0)
    inner_height = max((height - top - sum(_height_about(row) for row in rows)) / len(rows), 1.0)
    y = height - top
    for row in rows:
        y -= max(cell.top for cell in row) + inner_height
        for number, cell in enumerate(row):
            x = number * width / columns + left
            cell.axes.set_position((x / width, y / height, inner_width / width, inner_height / height))
        y -= max(cell.bottom for cell in row)


def _width_of(axes: Axes, radius: float) -> float:
    """The width in points of print of a line that covers all within a radius in data."""
    pixels = axes.transData.transform([[0.0, 0.0], [2.0 * radius, 0.0]])
    return float(pixels[1, 0] - pixels[0, 0]) * POINTS_PER_INCH / DPI


def _draw_panel(axes: Axes, panel: Panel) -> Tuple[List[Tuple[Line2D, Band]], List[Tuple[Any, str]]]:
    """Returns the bands, whose lines still need a width, and what the legend has to name."""
    axes.set_title(panel.title, y=1.0, parse_math=False)
    axes.set_xlabel(panel.x_label, parse_math=False)
    axes.set_ylabel(panel.y_label, parse_math=False)
    axes.set_axisbelow(True)
    axes.grid(True)
    marked = any(curve.marks != "none" for curve in panel.curves)
    axes.margins(x=0.05 if not panel.axes else 0.02 if marked else 0.0, y=0.05)
    axes.set_xscale(panel.x_scale)
    axes.set_yscale(panel.y_scale)
    legend: List[Tuple[Any, str]] = []
    for polygons in _by_look(panel):
        first = polygons[0]
        edge = first.edge or first.color
        outlines = [np.column_stack([p.x, p.y]) for p in polygons]
        axes.add_collection(PolyCollection(outlines, facecolors=first.color, edgecolors=edge, linewidths=0.6))
        legend += [(Patch(facecolor=p.color, edgecolor=edge), p.name) for p in polygons]
    bands: List[Tuple[Line2D, Band]] = []
    for band in panel.bands:
        (line,) = axes.plot(band.x, band.y, color=band.color, solid_capstyle="round", solid_joinstyle="round", zorder=1)
        bands.append((line, band))
        legend.append((Patch(color=band.color), band.name))
    for bars in panel.bars:
        axes.stairs(bars.heights, bars.edges, fill=True, color=bars.color, alpha=0.85)
        legend.append((Patch(color=bars.color), bars.name))
    for curve in panel.curves:
        (line,) = axes.plot(
            curve.x,
            curve.y,
            color=curve.color,
            linestyle=_turn(LINES[curve.line], curve.turn),
            linewidth=curve.width,
            marker=_turn(MARKS[curve.marks], curve.turn),
            markersize=curve.mark_size,
            markeredgewidth=0.0 if curve.marks == "dot" else 1.8,
            zorder=3,
        )
        seen = Line2D([], [])  # small marks are not seen in a legend
        seen.update_from(line)
        seen.set_markersize(max(curve.mark_size, LEGEND_MARK))
        legend.append((seen, curve.name))
    for shade in panel.shades:
        for first, last in shade.intervals:
            axes.axvspan(first, last, shade.low, shade.high, color=shade.color, linewidth=0.0, zorder=0)
        legend.append((Patch(color=shade.color), shade.name))
    if not _any_point(panel):
        axes.set(xscale="linear", yscale="linear", xlim=(0.0, 1.0), ylim=(0.0, 1.0))
        axes.text(0.5, 0.5, "no samples", ha="center", va="center", color="#808080", transform=axes.transAxes)
    else:
        _limit(axes, panel)
    if not panel.axes:
        axes.set_axis_off()
    return bands, [(handle, name) for handle, name in legend if name]


def _turn(looks: List[Any], turn: int) -> Any:
    return looks[turn % len(looks)]


def _by_look(panel: Panel) -> List[List[Any]]:
    """Neighbours among the polygons that look the same: one collection each keeps their order."""
    groups: List[List[Any]] = []
    for polygon in panel.polygons:
        if not groups or (groups[-1][0].color, groups[-1][0].edge) != (polygon.color, polygon.edge):
            groups.append([])
        groups[-1].append(polygon)
    return groups


def _any_point(panel: Panel) -> bool:
    def any_of(x: Array, y: Array) -> bool:
        return bool(np.any(np.isfinite(x) & np.isfinite(y)))

    lines: List[Any] = [*panel.curves, *panel.bands, *panel.polygons]
    return any(any_of(line.x, line.y) for line in lines) or any(len(bars.heights) for bars in panel.bars)


def _limit(axes: Axes, panel: Panel) -> None:
    axes.autoscale_view()
    if panel.x_scale == "linear":
        axes.set_xlim(*_to_ticks(axes.xaxis))
    axes.set_xlim(*panel.x_limits)
    axes.set_ylim(*panel.y_limits)
    if panel.equal:
        axes.set_aspect("equal", adjustable="box")
    for axis, scale in ((axes.xaxis, panel.x_scale), (axes.yaxis, panel.y_scale)):
        if scale == "log":
            _plain_numbers(axis)


def _to_ticks(axis: Any) -> Tuple[float, float]:
    """From where to where it goes, with the tick beyond an end that is all but reached: 5 s of steps that begin at 4.99."""
    low, high = axis.get_view_interval()
    near = NEAR_TICK * (high - low)
    for tick in axis.get_major_locator().tick_values(low, high):
        low = tick if low - near < tick < low else low
        high = tick if high < tick < high + near else high
    return low, high


def _plain_numbers(axis: Any) -> None:
    """0.01, 0.1, 1, 10 in place of powers of ten, and some between them where there are few."""
    low, high = axis.get_view_interval()
    powers = np.floor(np.log10(high)) - np.ceil(np.log10(low)) + 1  # of ten, within
    between = (1.0,) if powers > 2 else (1.0, 2.0, 5.0) if powers > 1 else (1.0, 2.0, 3.0, 5.0)
    axis.set_major_locator(LogLocator(subs=between, numticks=12))
    axis.set_minor_formatter(NullFormatter())

    def text(value: float, _: Any) -> str:
        if LEAST_PLAIN <= value <= LARGEST_PLAIN:
            return f"{value:g}"
        power = int(np.floor(np.log10(value) + 1e-9))
        times = value / 10.0**power
        return f"$10^{{{power}}}$" if abs(times - 1.0) < 1e-6 else f"${times:g}\\cdot10^{{{power}}}$"

    axis.set_major_formatter(FuncFormatter(text))


def _legend(axes: Axes, entries: List[Tuple[Any, str]], **where: Any) -> Legend:
    # numbers first: matplotlib leaves out names that begin with "_"
    legend = axes.legend([handle for handle, _ in entries], [str(i) for i in range(len(entries))], borderaxespad=0.0, **where)
    for text, (_, name) in zip(legend.get_texts(), entries):
        text.set_parse_math(False)
        text.set_text(name)
    return legend


def _legend_below(axes: Axes, entries: List[Tuple[Any, str]], room: float, **where: Any) -> Legend:
    """In as few lines as there is room for."""
    for columns in range(len(entries), 0, -1):
        legend = _legend(axes, entries, loc="upper center", bbox_to_anchor=(0.5, 0.0), ncol=columns, **where)
        if columns == 1 or legend.get_window_extent().width <= room:
            break
    return legend
