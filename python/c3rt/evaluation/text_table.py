"""Tables of text."""

from __future__ import annotations

import math
from typing import List, Sequence

Rows = Sequence[Sequence[str]]


def text_table(rows: Rows) -> str:
    """The first column left, the others right; a row of one cell is a heading. Ends with a new line."""
    widths = [0] * max((len(row) for row in rows), default=0)
    for row in rows:
        if len(row) > 1:
            for column, cell in enumerate(row):
                widths[column] = max(widths[column], len(cell))
    return "".join(_line(row, widths) + "\n" for row in rows)


def _line(row: Sequence[str], widths: Sequence[int]) -> str:
    if len(row) < 2:
        return "".join(row).rstrip(" ")
    cells = [row[0].ljust(widths[0])] + [cell.rjust(width) for cell, width in zip(row[1:], widths[1:])]
    return "  ".join(cells).rstrip(" ")


def markdown_table(rows: Rows) -> str:
    """The same in Markdown; the first row is the head, a row of one cell becomes bold."""
    columns = max((len(row) for row in rows), default=0)
    lines: List[str] = []
    for row in rows:
        first = f"**{row[0]}**" if len(row) == 1 else row[0]
        cells = [first, *row[1:]] + [""] * (columns - len(row))
        lines.append("|" + "".join(f" {cell} |" for cell in cells))
    lines.insert(1, "|" + " --- |" * columns)
    return "".join(f"{line}\n" for line in lines)


def shown(value: float, digits: int = 4) -> str:
    """Of at most this many digits, "-" where there is none."""
    return f"{value:.{digits}g}" if math.isfinite(value) else "-"


def shortest(value: float) -> str:
    """As few digits as give the same number again: "12.5", "2"."""
    text = repr(float(value))
    return text[:-2] if text.endswith(".0") else text
