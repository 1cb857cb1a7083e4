"""How a command ends, and what a person is told of it."""

from __future__ import annotations

import contextlib
import os
import sys

# what every command of c3rt exits with
DONE = 0  # and the criteria are met
CRITERION_FAILED = 1  # it ran, but a criterion failed
USAGE = 2  # the call or the scenario is wrong
PROCESS_FAILED = 3  # a process failed; it has been named
UNDECIDED = 4  # ended by a limit or by rounding before it had an answer


class UsageError(Exception):
    """The person asked for something that does not exist or does not fit."""


def tell(text: str) -> None:
    """A line on standard output. RuntimeError where it does not get there."""
    try:
        print(text, flush=True)
    except OSError as error:
        # what is left in the buffer would be tried again at the end
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise RuntimeError(f"cannot write to standard output: {error.strerror}") from None


def say(text: str) -> None:
    """A line on standard error, whatever has become of it."""
    with contextlib.suppress(OSError):
        print(text, file=sys.stderr, flush=True)


def complain(error: object) -> None:
    say(f"c3rt: error: {error}")
