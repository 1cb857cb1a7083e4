"""`c3rt reproduce`: the tables and figures of the paper, our numbers beside its own."""

from __future__ import annotations

from typing import Callable, Dict

from .engine import Stop
from .groups import Interrupted
from .reproduction import Reproduction, Settings
from .status import CRITERION_FAILED, DONE, UsageError, say
from .targets.circles import fig11, fig14, fig17
from .targets.comparison import comparison
from .targets.examples import fig3, fig5, fig7, fig8
from .targets.gap import gap
from .targets.horizon_tables import table1, table2
from .targets.push_anything import push_anything
from .targets.table3 import table3
from .targets.timed_paths import fig16, fig18

TARGETS: Dict[str, Callable[[Reproduction], None]] = {
    target.__name__: target for target in (comparison, fig11, fig14, fig16, fig17, fig18, fig3, fig5, fig7, fig8, gap,
                                           push_anything, table1, table2, table3)}


def run(settings: Settings, stop: Stop) -> int:
    """Prints the table and writes WHAT.json; runs are kept and used again by the next call with equal settings.

    Returns DONE, or CRITERION_FAILED where it was interrupted.
    """
    if settings.what not in TARGETS:
        raise UsageError(f'"{settings.what}": expected one of {", ".join(TARGETS)}')
    try:
        TARGETS[settings.what](Reproduction(settings, stop))
    except Interrupted:
        say("interrupted; what was finished is kept, and the same command goes on from there")
        return CRITERION_FAILED
    return DONE
