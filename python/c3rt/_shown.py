"""What the programs that a command of c3rt becomes have in common: c3rt.view, c3rt.ros, c3rt.evaluation."""

from __future__ import annotations

import argparse
import json
import pathlib
import signal
from typing import Any, Callable, Dict, List


def parser_of(name: str, description: str) -> argparse.ArgumentParser:
    """The words that `c3rt NAME` gives every one of them."""
    parser = argparse.ArgumentParser(prog=f"python -m c3rt.{name}", description=description)
    parser.add_argument("scene", type=pathlib.Path, help=f"as c3rt {name} writes it; it is removed")
    parser.add_argument("--domain", type=int, default=0)
    parser.add_argument("--profile", default="loopback")
    return parser


def take_scene(file: pathlib.Path) -> Dict[str, Any]:
    """Reads and removes it."""
    scene: Dict[str, Any] = json.loads(file.read_text())
    file.unlink()
    return scene


def until_interrupted() -> Callable[[], bool]:
    """Takes SIGINT and SIGTERM; tells whether one has come."""
    ended: List[bool] = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ended.append(True))
    return lambda: bool(ended)
