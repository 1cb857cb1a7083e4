"""What `c3rt view` starts: python -m c3rt.view SCENE.json [--domain D] [--profile P] [--port N]"""

from __future__ import annotations

import argparse
import json
import pathlib
import signal
import sys
from typing import List

from c3rt.client import Client

from .page import Page


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m c3rt.view", description=__doc__)
    parser.add_argument("scene", type=pathlib.Path, help="as c3rt view writes it; it is removed")
    parser.add_argument("--domain", type=int, default=0)
    parser.add_argument("--profile", default="loopback")
    parser.add_argument("--host", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=8080)
    given = parser.parse_args()
    scene = json.loads(given.scene.read_text())
    given.scene.unlink()
    ended: List[bool] = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ended.append(True))
    with Client(given.domain, given.profile) as client:
        page = Page(client, scene, given.host, given.port)
        print(f"http://{given.host}:{page.port}  (Ctrl-C ends it)", flush=True)
        try:
            page.run(lambda: bool(ended))
        finally:
            page.stop()
    return 0


if __name__ == "__main__":
    sys.exit(main())
