"""Recordings as tables: `run.mcap` of a run, and what `c3rt record` wrote.

    recording = c3rt.log.read("out/circle_slow-20260101-120000/run.mcap")
    recording["robot/state"].plot(x="time_s", y="p_WE_m_2")

Needs pandas: pip install './python[log]'. A row is a sample; columns are the fields of docs/clients.md: arrays by element
(`q_rad_0`), structs by field (`knots_0_p_WE_m_2`), enumerators by their words, and `time_s`, which is 0 at the first sample of the
recording. What is longer than 16, as the predicted horizon, is one column of numpy arrays.
"""

from __future__ import annotations

import json
import os
from typing import Any, Dict, Iterable, Iterator, Mapping, Optional, Union

try:
    import pandas as pd
except ImportError as error:
    raise ImportError("c3rt.log needs the package pandas: pip install './python[log]' (docs/clients.md)") from error

from . import _core


class Recording(Mapping[str, "pd.DataFrame"]):
    """Frames by topic, and what the recording says of its run."""

    def __init__(self, frames: Dict[str, pd.DataFrame], attachments: Dict[str, bytes], metadata: Dict[str, Dict[str, str]],
                 other: Dict[str, str], cut_off: str) -> None:
        self._frames = frames
        self.attachments = attachments
        self.metadata = metadata
        self.other = other  # topics that are not of this contract, and why
        self.cut_off = cut_off  # why it ends early, as after a crash; else ""

    @property
    def scenario(self) -> Optional[str]:
        """YAML, with nothing that it extends; None where the recording has none."""
        text = self.attachments.get("scenario.yaml")
        return None if text is None else text.decode()

    @property
    def report(self) -> Optional[Dict[str, Any]]:
        """Of the run, if it ended; `c3rt report FILE` makes one of any recording."""
        text = self.attachments.get("report.json")
        return None if text is None else json.loads(text)

    def __getitem__(self, topic: str) -> pd.DataFrame:
        if topic not in self._frames:
            raise KeyError(f"topic: expected one of {', '.join(self._frames)}, got {topic!r}")
        return self._frames[topic]

    def __iter__(self) -> Iterator[str]:
        return iter(self._frames)

    def __len__(self) -> int:
        return len(self._frames)


def read(path: Union[str, "os.PathLike[str]"], topics: Optional[Iterable[str]] = None) -> Recording:
    """Reads a recording, or of it these topics alone; of one that was cut off all that can be read.

    ValueError names a file that is no recording, or a topic of which it has no sample."""
    if isinstance(topics, str):
        raise TypeError(f"topics: expected a list of names, got the text {topics!r}")
    wanted = None if topics is None else set(topics)
    found = _core.read_recording(os.fspath(path), wanted)
    columns = found["frames"]
    if wanted is not None and wanted != columns.keys():
        raise ValueError(f"topics: {', '.join(sorted(wanted - columns.keys()))}: no samples in {os.fspath(path)}")
    first_ns = min((of_topic["time_ns"].min() for of_topic in columns.values()), default=0)
    frames = {topic: _frame(of_topic, first_ns) for topic, of_topic in columns.items()}
    return Recording(frames, found["attachments"], found["metadata"], found["other"], found["why"])


def _frame(columns: Dict[str, Any], first_ns: int) -> pd.DataFrame:
    cells: Dict[str, Any] = {"time_s": 1e-9 * (columns["time_ns"] - first_ns)}
    for name, values in columns.items():
        cells[name] = list(values) if getattr(values, "ndim", 1) > 1 else values
    return pd.DataFrame(cells)
