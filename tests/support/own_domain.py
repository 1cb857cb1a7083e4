"""DDS domains of a test's own, as tests run beside each other (tests/support/own_domain.hpp)."""

import fcntl
import os
from typing import List

_COUNT = 76
_held: List[int] = []


def take_domain() -> int:
    """A domain that no other test on this machine has: this process holds the domain's file until it ends."""
    for i in range(_COUNT):
        domain = 1 + (os.getpid() + i) % _COUNT
        try:
            held = os.open(f"/tmp/c3rt-test-domain-{domain}", os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
        except PermissionError:  # another user's
            continue
        try:
            fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(held)
            continue
        _held.append(held)
        return domain
    raise RuntimeError(f"tests hold all DDS domains from 1 to {_COUNT}")
