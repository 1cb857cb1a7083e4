"""Draws many pictures in one process: python -m c3rt.pictures < pictures.json

The document is {"pictures": [{"file": PNG, "figure": FIGURE}, …]}. The answer is one line of JSON, {"missing": {FILE: REASON}},
of those that could not be drawn; exit status 0, 1 where one is missing, and 2 for a document that is none.
"""

from __future__ import annotations

import json
import sys
from typing import Dict

from .figure import draw


def main() -> int:
    try:
        pictures = [(picture["file"], picture["figure"]) for picture in json.load(sys.stdin)["pictures"]]
    except (ValueError, KeyError, TypeError) as error:
        print(f'expected {{"pictures": [{{"file": …, "figure": …}}, …]}}: {error!r}', file=sys.stderr)
        return 2
    missing: Dict[str, str] = {}
    for file, figure in pictures:
        try:
            draw(figure, file)
        except OSError as error:
            missing[file] = f"could not write the file: {error.strerror}"
        except Exception as error:  # the others are drawn
            missing[file] = str(error)
    print(json.dumps({"missing": missing}))
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main())
