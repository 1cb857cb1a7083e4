"""A camera of one's own: pictures from files, the ball found in each, as object/estimate. It needs no emulated camera and no
truth: what reads the files could read a device.

    python examples/image_files/camera.py FOLDER --clock lockstep &      # 000.pgm, 001.pgm, …: 8 bits, a bright ball
    c3rt run circle_slow --without vision --clock lockstep

The camera looks straight down: a pixel is a place on the table, from the corner CORNER_M, x to the right and y up.
"""
import pathlib
import re
import sys

import numpy as np

from c3rt.client import Estimate, Estimator

METRES_PER_PIXEL = 0.001
CORNER_M = (0.35, 0.3)  # of the picture's upper left corner, in W
HEIGHT_M = 0.007  # of the ball's centre
BRIGHT = 128  # a pixel of the ball is brighter
LEAST_PIXELS = 50  # of a ball


def read_pgm(file):
    """A picture of the format P5 without comments, as (height, width)."""
    data = file.read_bytes()
    header = re.match(rb"P5\s+(\d+)\s+(\d+)\s+255\s", data)
    if header is None:
        raise ValueError(f"{file}: expected a PGM of 8 bits: P5 WIDTH HEIGHT 255, got {data[:20]!r}")
    width, height = int(header[1]), int(header[2])
    return np.frombuffer(data, np.uint8, width * height, header.end()).reshape(height, width)


class Files(Estimator):
    """A file for each period; after the last one nothing new is seen."""

    of_exposures, rate_hz = False, 50.0

    def __init__(self, folder):
        self.files = iter(sorted(pathlib.Path(folder).glob("*.pgm")))
        self.last = None

    def estimate(self, time_s, truth):
        file = next(self.files, None)
        if file is None:
            return []
        rows, columns = np.nonzero(read_pgm(file) > BRIGHT)
        if len(rows) < LEAST_PIXELS:
            self.say(f"no ball in {file.name}", degraded=True)
            return []
        p = np.array([CORNER_M[0] + METRES_PER_PIXEL * (columns.mean() + 0.5),
                      CORNER_M[1] - METRES_PER_PIXEL * (rows.mean() + 0.5), HEIGHT_M])
        v = np.zeros(3) if self.last is None else (p - self.last) * self.rate_hz
        self.last = p
        return [Estimate(0, p, v=v)]


if __name__ == "__main__":
    if len(sys.argv) < 2 or not pathlib.Path(sys.argv[1]).is_dir():
        sys.exit("camera.py: error: expected the folder of the pictures first")
    Files(sys.argv[1]).main(sys.argv[2:])
