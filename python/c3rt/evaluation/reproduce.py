"""`c3rt reproduce`: of its tables and figures those that are made here."""

from __future__ import annotations

from typing import Callable, Dict

from .engine import Stop
from .groups import Interrupted
from .push_anything import push_anything
from .reproduction import Reproduction, Settings
from .status import CRITERION_FAILED, DONE, say

TARGETS: Dict[str, Callable[[Reproduction], None]] = {"push_anything": push_anything}


def run(settings: Settings, stop: Stop) -> int:
    """Prints the table and writes WHAT.json; runs are kept and used again by the next call with equal settings.

    Returns DONE, or CRITERION_FAILED where it was interrupted.
    """
    try:
        TARGETS[settings.what](Reproduction(settings, stop))
    except Interrupted:
        say("interrupted; what was finished is kept, and the same command goes on from there")
        return CRITERION_FAILED
    return DONE
