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
from page import browser, c3rt, text_of, tick_cameras, until, view

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
    """Seconds of processors since the start: of all, and of what c3rt, the page and the browser are made of."""
    fields = [int(word) for word in pathlib.Path("/proc/stat").read_text().split("\n")[0].split()[1:]]
    hertz = os.sysconf("SC_CLK_TCK")
    ours = 0
    for folder in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            name, rest = (folder / "stat").read_text().rsplit(")", 1)
            words = (folder / "cmdline").read_text()
        except OSError:
            continue
        if "c3rt" in words or "chrom" in words:
            ours += sum(int(word) for word in rest.split()[11:13])
    return (sum(fields) - fields[3] - fields[4]) / hertz, ours / hertz


def window(client):
    before, (all_before, ours_before) = counters(client), busy()
    time.sleep(WINDOW_S)
    after, (all_after, ours_after) = counters(client), busy()
    seen = {key: after[key] - before[key] for key in after if key[1] != "rate_hz"}
    seen |= {key: after[key] for key in after if key[1] == "rate_hz"}
    ours = (ours_after - ours_before) / WINDOW_S
    seen["processors", "ours"], seen["processors", "others"] = ours, (all_after - all_before) / WINDOW_S - ours
    return seen


def turn(folder):
    """One service: nobody, page, pictures, pictures, page, nobody."""
    up = c3rt("up", SCENARIO, "--out", folder)
    assert up.returncode == 0, up.stderr
    seen = []
    try:
        with Client() as client:
            def look(way):
                time.sleep(SETTLE_S)
                seen.append((way, window(client)))

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
    print(f"{SCENARIO}, windows of {WINDOW_S:g} s, {2 * turns} each way, {os.cpu_count()} processors; median (least to most)")
    for way in ("nobody looks", "page", "page with pictures"):
        print(way)
        for key in keys:
            values = sorted(row[key] for is_way, row in rows if is_way == way)
            print(f"  {key[0]:10} {key[1]:15} {statistics.median(values):10.2f} ({values[0]:.2f} to {values[-1]:.2f})")


if __name__ == "__main__":
    main()
