"""What the page takes from a service in real time: cycles that impedance and plant miss and periods that the planner overruns, with
and without the page, interleaved (tests/view.sh --load TURNS).

Three ways: nobody looks; the page open in a headless Chromium on the same machine, which draws without a graphics card; the same with
the cameras' pictures. A turn goes there and back again, so that what else the machine does falls on all of them."""

import os
import pathlib
import statistics
import sys
import tempfile
import time

from c3rt.client import Client
from page import browser, c3rt, going, text_of, tick_cameras, until, view

SCENARIO = "circle_vision"
WINDOW_S, SETTLE_S = 20.0, 8.0
COUNTERS = (("impedance", "missed_cycles"), ("plant", "missed_cycles"), ("planner", "overruns"), ("vision", "dropped_frames"))


def counters(client):
    statuses = client.status(5.0)
    out = {}
    for process, name in COUNTERS:
        status = statuses[process]
        names = list(status.counter_names)
        if name in names:
            out[process, name] = status.counters[names.index(name)]
        out[process, "rate_hz"] = status.rate_hz
    return out


def busy():
    """Seconds that the machine's processors have worked, for whomever."""
    fields = [int(word) for word in pathlib.Path("/proc/stat").read_text().split("\n")[0].split()[1:]]
    return (sum(fields) - fields[3] - fields[4]) / os.sysconf("SC_CLK_TCK")


def worked(process):
    """Seconds of a core that a process has taken."""
    fields = pathlib.Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def window(client, recorder):
    before, busy_before, worked_before = counters(client), busy(), worked(recorder)
    time.sleep(WINDOW_S)
    after, busy_after, worked_after = counters(client), busy(), worked(recorder)
    seen = {key: after[key] - before[key] for key in after if key[1] != "rate_hz"}
    seen |= {key: after[key] for key in after if key[1] == "rate_hz"}
    seen["record", "of a core"] = (worked_after - worked_before) / WINDOW_S
    seen["machine", "busy"] = (busy_after - busy_before) / WINDOW_S  # processors
    seen["machine", "load"] = os.getloadavg()[0]
    return seen


def turn(folder):
    """One service: nobody, page, pictures, pictures, page, nobody."""
    up = c3rt("up", SCENARIO, "--out", folder)
    assert up.returncode == 0, up.stderr
    seen = []
    try:
        with Client() as client, going("record", folder / "run.mcap") as recorder:
            def look(way):
                time.sleep(SETTLE_S)
                seen.append((way, window(client, recorder)))

            look("nobody looks")
            with view(), browser() as driver:
                until(lambda: "robot: move" in text_of(driver))
                look("page")
                tick_cameras(driver)
                look("page with pictures")
                look("page with pictures")
                tick_cameras(driver)
                look("page")
            look("nobody looks")
    finally:
        c3rt("down")
    return seen


def main():
    turns = int(sys.argv[1])
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for i in range(turns):
            rows += turn(pathlib.Path(folder) / f"{i}")
            print(f"turn {i + 1} of {turns}, load {os.getloadavg()[0]:.1f}", flush=True)
    keys = list(rows[0][1])
    print(f"{SCENARIO}, recorded, windows of {WINDOW_S:g} s, {2 * turns} each way, {os.cpu_count()} processors; median (least to most)")
    for way in ("nobody looks", "page", "page with pictures"):
        print(way)
        for key in keys:
            values = sorted(row[key] for is_way, row in rows if is_way == way)
            print(f"  {key[0]:10} {key[1]:15} {statistics.median(values):10.2f} ({values[0]:.2f} to {values[-1]:.2f})")


if __name__ == "__main__":
    main()
