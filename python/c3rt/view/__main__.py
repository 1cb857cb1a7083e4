"""What `c3rt view` starts: python -m c3rt.view SCENE.json [--domain D] [--profile P] [--port N]"""

from __future__ import annotations

import sys

from c3rt._shown import parser_of, take_scene, until_interrupted
from c3rt.client import Client

from .page import Page


def main() -> int:
    parser = parser_of("view", __doc__)
    parser.add_argument("--host", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=8080)
    given = parser.parse_args()
    scene = take_scene(given.scene)
    ended = until_interrupted()
    with Client(given.domain, given.profile) as client:
        page = Page(client, scene, given.host, given.port)
        print(f"http://{given.host}:{page.port}  (Ctrl-C ends it)", flush=True)
        try:
            page.run(ended)
        finally:
            page.stop()
    return 0


if __name__ == "__main__":
    sys.exit(main())
