"""How far a computation has come: one line on standard error."""

from __future__ import annotations

import contextlib
import os
import sys
import time

from .status import say

QUIET_S, TERMINAL_PERIOD_S, LINE_PERIOD_S = 1.0, 0.2, 10.0
BAR = 12


def shown_time(seconds: float) -> str:
    """As "3 min 20 s"."""
    whole = int(seconds + 0.5)
    return f"{whole} s" if whole < 60 else f"{whole // 60} min {whole % 60} s"


class Progress:
    """A line that is drawn over on a terminal, elsewhere a new one every ten seconds; nothing in the first second."""

    def __init__(self, title: str) -> None:
        self._title = title
        self._is_terminal = sys.stderr.isatty()
        self._is_drawn = False
        self._started = time.monotonic()
        self._drawn_at = self._started + (QUIET_S - TERMINAL_PERIOD_S if self._is_terminal else 0.0)

    def update(self, share: float, text: str) -> None:
        """Call it often; it draws when it is time. share: done so far, 0 … 1."""
        now = time.monotonic()
        if now - self._drawn_at < (TERMINAL_PERIOD_S if self._is_terminal else LINE_PERIOD_S):
            return
        self._drawn_at = now
        share = min(max(share, 0.0), 1.0)
        passed = now - self._started
        left = f", {shown_time(passed / share - passed)} left" if share > 0.01 else ""
        line = f"{self._title}  {100 * share:3.0f} %  {text} ({shown_time(passed)}{left})"
        if self._is_terminal:
            filled = int(share * BAR)
            self._draw(f"[{'#' * filled}{'.' * (BAR - filled)}] {line}")
        else:
            say(line)

    def close(self) -> None:
        """Clears the line."""
        if self._is_drawn:
            self._write("\r\x1b[K")

    def _draw(self, line: str) -> None:
        self._is_drawn = True
        self._write(f"\r{line[:_terminal_width() - 1]}\x1b[K")

    @staticmethod
    def _write(text: str) -> None:
        with contextlib.suppress(OSError):
            sys.stderr.write(text)
            sys.stderr.flush()


def _terminal_width() -> int:
    with contextlib.suppress(OSError):
        return os.get_terminal_size(sys.stderr.fileno()).columns or 80
    return 80
