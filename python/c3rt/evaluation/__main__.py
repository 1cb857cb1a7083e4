"""What `c3rt campaign`, `c3rt tune` and `c3rt reproduce` start: python -m c3rt.evaluation COMMAND ORDER

ORDER is what the command line said, as JSON; "program" is the c3rt that makes the runs.
"""

from __future__ import annotations

import json
import sys
from typing import Any, Callable, Dict

from c3rt._shown import until_interrupted

from . import campaign, reproduce, tune
from .status import PROCESS_FAILED, USAGE, UsageError, complain

COMMANDS: Dict[str, Callable[[Dict[str, Any], Callable[[], bool]], int]] = {
    "campaign": lambda order, stop: campaign.run(campaign.Settings(**order), stop),
    "tune": lambda order, stop: tune.run(tune.Settings(**order), stop),
    "reproduce": lambda order, stop: reproduce.run(reproduce.Settings(**order), stop),
}


def main() -> int:
    stop = until_interrupted()
    command, order = sys.argv[1:]
    try:
        return COMMANDS[command](json.loads(order), stop)
    except UsageError as error:
        complain(error)
        return USAGE
    except Exception as error:  # a person reads one sentence, as of every command
        complain(error)
        return PROCESS_FAILED


if __name__ == "__main__":
    sys.exit(main())
