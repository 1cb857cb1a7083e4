"""The next candidates of CMA-ES (the package cmaes), from all that is known of those before.

Called by `c3rt tune` with a line of JSON on standard input; the same input gives the same candidates:
  {"mean": [...], "sigma": S, "seed": N, "population": P, "generations": [{"candidates": [[...]], "ranks": [...]}]}
Numbers are in [0, 1]. Answers with a line of JSON: {"candidates": [[...], ...]}.
"""

import json
import sys

import numpy as np
from cmaes import CMA


def main():
    order = json.load(sys.stdin)
    mean = np.array(order["mean"])
    optimiser = CMA(mean=mean, sigma=order["sigma"], bounds=np.array([[0.0, 1.0]] * len(mean)), seed=order["seed"],
                    population_size=order["population"])
    for number, generation in enumerate(order["generations"], 1):
        asked = [optimiser.ask() for _ in range(order["population"])]
        if not np.allclose(asked, generation["candidates"], rtol=0.0, atol=1e-12):
            print(f"generation {number} was drawn by another version of the package cmaes: begin anew with --fresh")
            return 2
        optimiser.tell(list(zip(asked, generation["ranks"])))
    print(json.dumps({"candidates": [optimiser.ask().tolist() for _ in range(order["population"])]}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
