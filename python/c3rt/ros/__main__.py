"""What `c3rt ros` starts: python -m c3rt.ros SCENE.json [--domain D] [--profile P] [--ros-domain N]"""

from __future__ import annotations

import argparse
import json
import pathlib
import signal
import sys
from typing import List

from c3rt.client import Client

from .border import Border, Ros, names_of


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m c3rt.ros", description=__doc__)
    parser.add_argument("scene", type=pathlib.Path, help="as c3rt ros writes it; it is removed")
    parser.add_argument("--domain", type=int, default=0)
    parser.add_argument("--profile", default="loopback")
    parser.add_argument("--ros-domain", type=int, default=0)
    parser.add_argument("--frame", default="panda_link0")
    parser.add_argument("--rate", type=float, default=100.0)
    given = parser.parse_args()
    scene = json.loads(given.scene.read_text())
    given.scene.unlink()
    ended: List[bool] = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ended.append(True))
    try:
        with Client(given.domain, given.profile) as client:
            border = Border(client, Ros(given.ros_domain), scene, given.frame, given.rate)
            names = ", ".join("/" + name for name in names_of(len(scene["objects"])))
            print(f"ROS domain {given.ros_domain}: {names}  (Ctrl-C ends it)", flush=True)
            border.run(lambda: bool(ended))
    except ConnectionError as error:
        print(f"c3rt: ros: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
