"""An estimator of one's own: the simulation's truth with noise, through a filter of one's own, as object/estimate.

    python examples/estimator/estimator.py --clock lockstep &
    c3rt run circle_slow --without vision --clock lockstep
"""
import numpy as np

from c3rt.client import Estimate, Estimator

NOISE_M = 0.001  # standard deviation along each axis
POSITION_WEIGHT, VELOCITY_WEIGHT = 0.4, 0.1  # of a new measurement


class Tracked:
    """An alpha-beta filter: position and velocity, corrected by what a measurement is off from where they lead."""

    def __init__(self, p):
        self.p, self.v = p, np.zeros(3)

    def take(self, measured, period):
        ahead = self.p + period * self.v
        off = measured - ahead
        self.p = ahead + POSITION_WEIGHT * off
        self.v = self.v + VELOCITY_WEIGHT / period * off


class Noisy(Estimator):
    """Sees every object of the scene at each exposure, a millimetre wrong."""

    def __init__(self, seed=1):
        self.random, self.tracked = np.random.default_rng(seed), {}

    def estimate(self, time_s, truth):
        estimates = []
        for index, body in enumerate(truth.objects[: truth.object_count]):
            measured = np.array(body.p_WB_m) + self.random.normal(0.0, NOISE_M, 3)
            if index not in self.tracked:
                self.tracked[index] = Tracked(measured)
            known = self.tracked[index]
            known.take(measured, 1.0 / self.rate_hz)
            estimates.append(Estimate(index, known.p, q=body.q_WB, v=known.v, omega=body.omega_rad_per_s))
        return estimates


if __name__ == "__main__":
    Noisy().main()
