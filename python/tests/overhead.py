"""What a call from Python costs beside the solver's own time: the ball of the scenarios' size, another x0 each time.

    python python/tests/overhead.py
"""

import statistics
import time

import numpy as np

import c3rt

random = np.random.default_rng(1)
n_x, n_lambda, n_u = 19, 8, 3
lcs = c3rt.LCS(np.eye(n_x), random.normal(size=(n_x, n_u)), 0.1 * random.normal(size=(n_x, n_lambda)), np.zeros(n_x),
               random.normal(size=(n_lambda, n_x)), 3 * np.eye(n_lambda), np.zeros((n_lambda, n_u)), np.ones(n_lambda))
solver = c3rt.Solver(c3rt.Problem(lcs, np.ones(n_x), projection="C3+", N=5, s=3, rho=1, Q=np.eye(n_x), QN=np.eye(n_x),
                                  R=np.eye(n_u), xd=np.zeros(n_x), g_lambda=1, g_eta=1, u_lambda=1, u_eta=1))
starts = random.normal(size=(5000, n_x))
whole, beside = [], []
for x0 in starts:
    begin = time.perf_counter()
    result = solver.solve(x0)
    u = result.u[0]
    whole.append(time.perf_counter() - begin)
    beside.append(whole[-1] - result.solve_time_s)
print(f"solve and read u, {len(starts)} calls: p50 {statistics.median(whole) * 1e6:.1f} us, of these beside the solver "
      f"p50 {statistics.median(beside) * 1e6:.1f}  p95 {statistics.quantiles(beside, n=20)[-1] * 1e6:.1f} us")
