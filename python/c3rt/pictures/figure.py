"""Draws what a description says, by matplotlib."""

from __future__ import annotations

import io
import os
import pathlib
from typing import Any, List, Tuple, Union

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

from .description import PALETTE, Array, Band, DescriptionError, Panel, figure_of

__all__ = ["PALETTE", "DescriptionError", "draw"]

DPI = 100
PANEL_WIDTH, PANEL_HEIGHT, TITLE_HEIGHT, LEGEND_WIDTH = 760, 290, 40, 180  # [pixels]
SQUARE = 520  # a panel seen from above [pixels]
MARGIN, LINE_HEIGHT, TICKS_HEIGHT, TICKS_WIDTH = 12, 19, 26, 92  # about a panel [pixels]
TITLE_SIZE = 12  # [points]
POINTS_PER_INCH = 72.0
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
MARKS = {"none": "None", "dot": "o", "cross": "x"}
LINES = {"none": "None", "solid": "-", "dashed": (0, (5, 3))}


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


def make(said: Any) -> Figure:
    """The figure of a description that was read (description.Figure)."""
    rows = -(-len(said.panels) // said.columns)
    width, height = said.size or _size_of(said.panels, said.columns, rows)
    figure = Figure(figsize=(width / DPI, height / DPI), dpi=DPI, facecolor="white")
    FigureCanvasAgg(figure)
    if said.title:
        y = 1.0 - 0.5 * TITLE_HEIGHT / height
        figure.text(0.5, y, said.title, size=TITLE_SIZE, ha="center", va="center", parse_math=False)
    cells = [_Cell(figure.add_axes((0.0, 0.0, 1.0, 1.0), label=str(number)), panel) for number, panel in enumerate(said.panels)]
    _place(figure, cells, said.columns, TITLE_HEIGHT if said.title else MARGIN)
    for cell in cells:
        cell.axes.apply_aspect()
        for line, band in cell.bands:
            line.set_linewidth(_width_of(cell.axes, band.radius))
    return figure


class _Cell:
    """A panel with what lies about it [pixels]."""

    def __init__(self, axes: Axes, panel: Panel) -> None:
        self.axes = axes
        self.bands, entries = _draw_panel(axes, panel)
        self.top = MARGIN + LINE_HEIGHT * (panel.title.count("\n") + 1 if panel.title else 0)
        self.bottom = (TICKS_HEIGHT if panel.axes else MARGIN) + (LINE_HEIGHT if panel.x_label else 0)
        self.left = TICKS_WIDTH if panel.axes else MARGIN
        self.right = 2 * MARGIN  # half of an axis' last number
        if entries and panel.legend == "right":
            legend = _legend(axes, entries, loc="upper left", bbox_to_anchor=(1.0, 1.0))
            self.right += legend.get_window_extent().width
        elif entries:
            columns = min(len(entries), 3)
            place = axes.transAxes + ScaledTranslation(0.0, -self.bottom / DPI, axes.figure.dpi_scale_trans)
            legend = _legend(axes, entries, loc="upper center", bbox_to_anchor=(0.5, 0.0), bbox_transform=place, ncol=columns)
            self.bottom += legend.get_window_extent().height + 2 * MARGIN


def _place(figure: Figure, cells: List[_Cell], columns: int, top: float) -> None:
    """Gives every panel as much room as the others, with their edges one above the other."""
    width, height = figure.get_size_inches() * DPI
    rows = [cells[first : first + columns] for first in range(0, len(cells), columns)]
    left, right = max(cell.left for cell in cells), max(cell.right for cell in cells)
    about = sum(max(cell.top for cell in row) + max(cell.bottom for cell in row) for row in rows)
    inner_width = max(width / columns - left - right, 1.0)
    inner_height = max((height - top - about) / len(rows), 1.0)
    y = height - top
    for row in rows:
        y -= max(cell.top for cell in row) + inner_height
        for number, cell in enumerate(row):
            x = number * width / columns + left
            cell.axes.set_position((x / width, y / height, inner_width / width, inner_height / height))
        y -= max(cell.bottom for cell in row)


def _size_of(panels: List[Panel], columns: int, rows: int) -> Tuple[int, int]:
    if any(panel.equal for panel in panels):
        return columns * SQUARE, rows * SQUARE + TITLE_HEIGHT
    beside = any(_named(panel) and panel.legend == "right" for panel in panels)
    return columns * (PANEL_WIDTH + beside * LEGEND_WIDTH), rows * PANEL_HEIGHT + TITLE_HEIGHT


def _named(panel: Panel) -> bool:
    drawn = (panel.curves, panel.shades, panel.bands, panel.bars, panel.polygons)
    return any(item.name for items in drawn for item in items)


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
    axes.margins(x=0.0 if panel.axes else 0.05, y=0.05)
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
            linestyle=LINES[curve.line],
            linewidth=curve.width,
            marker=MARKS[curve.marks],
            markersize=curve.mark_size,
            markeredgewidth=0.0 if curve.marks == "dot" else 1.8,
            zorder=3,
        )
        legend.append((line, curve.name))
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
    axes.set_xlim(*panel.x_limits)
    axes.set_ylim(*panel.y_limits)
    if panel.equal:
        axes.set_aspect("equal", adjustable="box")
    for axis, scale in ((axes.xaxis, panel.x_scale), (axes.yaxis, panel.y_scale)):
        if scale == "log":
            _plain_numbers(axis)


def _plain_numbers(axis: Any) -> None:
    """0.01, 0.1, 1, 10 in place of powers of ten, and between them where there is less than one decade."""
    low, high = axis.get_view_interval()
    decades = np.log10(high / low)
    axis.set_major_locator(LogLocator(subs=(1.0,) if decades > 1.5 else (1.0, 2.0, 5.0), numticks=12))
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
    legend = axes.legend([handle for handle, _ in entries], [str(i) for i in range(len(entries))], borderaxespad=0.6, **where)
    for text, (_, name) in zip(legend.get_texts(), entries):
        text.set_parse_math(False)
        text.set_text(name)
    return legend
