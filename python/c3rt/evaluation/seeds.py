"""Which seeds are run."""

from __future__ import annotations

import re
from typing import List, NoReturn, Set

from .status import UsageError

MOST = 100000
LARGEST = 2**64 - 1


def parse_seeds(text: str) -> List[int]:
    """The seeds of "1..50" or "1,5,9..12", in the order written.

    UsageError says what was expected, also for a seed named twice and for more than 100000 of them.
    """
    seeds: List[int] = []
    known: Set[int] = set()
    for word in text.split(","):
        first, dots, last = word.partition("..")
        begin = _parse_seed(first, text)
        end = _parse_seed(last, text) if dots else begin
        if end < begin:
            _refuse(text, f'"{word}" runs backwards')
        for seed in range(begin, end + 1):
            if seed in known:
                _refuse(text, f"seed {seed} comes twice")
            if len(seeds) == MOST:
                _refuse(text, f"more than {MOST} seeds")
            known.add(seed)
            seeds.append(seed)
    return seeds


def _parse_seed(word: str, text: str) -> int:
    if not re.fullmatch("[0-9]+", word) or int(word) > LARGEST:
        _refuse(text, f'"{word}" is no seed')
    return int(word)


def _refuse(text: str, why: str) -> NoReturn:
    raise UsageError(f'--seeds "{text}": {why}; expected whole numbers and ranges such as 1..50 or 1,5,9..12')
