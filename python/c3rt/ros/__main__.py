"""What `c3rt ros` starts: python -m c3rt.ros SCENE.json [--domain D] [--profile P] [--ros-domain N]"""

from __future__ import annotations

import sys

from c3rt._shown import parser_of, take_scene, until_interrupted
from c3rt.client import Client

from .border import Border, Ros, names_of


def main() -> int:
    parser = parser_of("ros", __doc__)
    parser.add_argument("--ros-domain", type=int, default=0)
    parser.add_argument("--frame", default="panda_link0")
    parser.add_argument("--rate", type=float, default=100.0)
    given = parser.parse_args()
    scene = take_scene(given.scene)
    ended = until_interrupted()
    try:
        with Client(given.domain, given.profile) as client:
            border = Border(client, Ros(given.ros_domain), scene, given.frame, given.rate)
            names = ", ".join("/" + name for name in names_of(len(scene["objects"])))
            print(f"ROS domain {given.ros_domain}: {names}  (Ctrl-C ends it)", flush=True)
            border.run(ended)
    except ConnectionError as error:
        print(f"c3rt: ros: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
