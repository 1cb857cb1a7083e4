"""CMA-ES, by the package cmaes: candidates of a generation from the ranks of those before."""

from __future__ import annotations

import math
from typing import List, Sequence


def usual_population(parameters: int) -> int:
    """4 + 3 ln n, as Hansen advises."""
    return 4 + int(3.0 * math.log(parameters))


class Optimiser:
    """Asked and told in turn; the same answers give the same candidates."""

    def __init__(self, mean: Sequence[float], sigma: float, seed: int, population: int) -> None:
        """mean: where it begins, in [0, 1]; two numbers at least. sigma: how far from there the first candidates are drawn."""
        import numpy as np
        from cmaes import CMA

        self.population = population
        self._optimiser = CMA(mean=np.array(mean), sigma=sigma, bounds=np.array([[0.0, 1.0]] * len(mean)), seed=seed,
                              population_size=population)

    def ask(self) -> List[List[float]]:
        """The next generation, in [0, 1]."""
        self._asked = [self._optimiser.ask() for _ in range(self.population)]
        return [candidate.tolist() for candidate in self._asked]

    def tell(self, ranks: Sequence[float]) -> None:
        """The place of each candidate of the generation, less is better."""
        self._optimiser.tell(list(zip(self._asked, ranks)))
