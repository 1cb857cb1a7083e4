import json
import os
import pathlib
import signal
import subprocess
import sys
import threading

import numpy as np
import pytest
from conftest import modes, parameters, random_blocks

import c3rt

PROJECTIONS = ["MIQP", "LCP", "ADMM", "CONVEX", "C3+"]
X0 = np.array([1.0, -0.5, 0.3, 0.2])


def problem(projection="C3+", seed=1, **changes):
    return c3rt.Problem(c3rt.LCS(**random_blocks(seed)), X0, **parameters(projection) | changes)


def as_file(projection, seed=1, **changes):
    """The same problem as docs/problem_files.md has it."""
    plain = {key: value.tolist() if isinstance(value, np.ndarray) else value
             for key, value in (parameters(projection) | changes).items()}
    top = {key: plain.pop(key) for key in ("projection", "method", "trace") if key in plain}
    lcs = {name: block.tolist() for name, block in random_blocks(seed).items()}
    return {"schema": "c3-problem-1", "lcs": lcs, "x0": X0.tolist(), "params": plain, **top}


def test_the_projections_are_all_there():
    assert c3rt.projections() == PROJECTIONS


@pytest.mark.parametrize("projection, method", [(p, "C3") for p in PROJECTIONS] + [("MIQP", "MIQP15")])
def test_the_answer_is_that_of_the_command_line(tmp_path, projection, method):
    file = tmp_path / "problem.json"
    file.write_text(json.dumps(as_file(projection, method=method)))
    command = [os.environ["C3RT_PROGRAM"], "solve", str(file)]
    expected = json.loads(subprocess.run(command, capture_output=True, check=True).stdout)
    for result in (problem(projection, method=method).solve(), c3rt.load_problem(file).solve()):
        assert result.ok and result.status == "ok" and result.found
        got = json.loads(result.to_json())
        assert got.pop("solve_time_s") > 0.0
        assert got == {key: value for key, value in expected.items() if key != "solve_time_s"}
        assert np.array_equal(result.x, expected["x"]) and np.array_equal(result.u, expected["u"])
        assert np.array_equal(result.lam, expected["lam"]) and result.iterations == expected["iterations"]


def test_a_trace_has_every_iterate():
    p = problem("MIQP")
    result = p.solve()
    assert len(result.trace) == result.iterations == 4
    assert [turn.rho for turn in result.trace] == [0.5, 0.75, 1.125, 1.6875]
    last = result.trace[-1]
    assert np.array_equal(last.delta, result.delta) and np.array_equal(last.omega, result.omega)
    # w <- (w + z - delta) / rho_s
    before = result.trace[-2]
    assert np.allclose(last.omega, (before.omega + last.z - last.delta) / 1.5, atol=1e-12)
    assert np.array_equal(last.z[:, :4], result.x[:-1])
    assert problem("MIQP", trace=False).solve().trace == []


def test_a_plan_obeys_its_dynamics_and_costs_what_it_says(blocks):
    result = problem("CONVEX").solve()
    b = blocks
    for k in range(5):
        x_next = b["A"] @ result.x[k] + b["B"] @ result.u[k] + b["D"] @ result.lam[k] + b["d"]
        assert np.allclose(result.x[k + 1], x_next, atol=1e-8)
    cost = (result.x[:-1] ** 2).sum() + 0.1 * (result.u ** 2).sum() + 3 * (result.x[-1] ** 2).sum()
    assert np.isclose(result.objective, cost, rtol=1e-10)


def test_a_projection_by_name_is_the_nearest_point(blocks):
    v = np.random.default_rng(3).normal(size=9)
    x, u = v[:4], v[7:]
    nearest = problem("LCP").project(v)
    assert np.allclose(nearest.delta[4:7], modes(blocks["F"], blocks["E"] @ x + blocks["H"] @ u + blocks["c"]))
    exact = problem("MIQP").project(v, stage=4)
    U = np.array([9.0] * 4 + [1.0] * 3 + [2.0] * 2)
    assert exact.ok and np.isclose(exact.objective, (U * (exact.delta - v) ** 2).sum())
    assert exact.objective <= (U * (nearest.delta - v) ** 2).sum() + 1e-9
    gap = blocks["E"] @ exact.delta[:4] + blocks["F"] @ exact.delta[4:7] + blocks["H"] @ exact.delta[7:] + blocks["c"]
    assert np.abs(np.minimum(gap, exact.delta[4:7])).max() < 1e-8
    # C3+: pair by pair the farther half-axis of 3 (lam - .)^2 + 4 (eta - .)^2
    v = np.concatenate([v, np.random.default_rng(4).normal(size=3)])
    lam, eta = v[4:7], v[9:]
    keeps = np.sqrt(3) * lam > 2 * eta
    plus = problem("C3+").project(v).delta
    assert np.array_equal(plus[4:7], np.where(keeps, np.maximum(lam, 0), 0))
    assert np.array_equal(plus[9:], np.where(keeps, 0, np.maximum(eta, 0)))
    with pytest.raises(ValueError, match=r"^v: expected the shape \(12,\), got \(9,\)"):
        problem("C3+").project(v[:9])
    with pytest.raises(ValueError, match=r"^stage: expected one in \[0, 4\], got 5"):
        problem("C3+").project(v, stage=5)


def test_a_solver_takes_another_state_system_and_target_as_a_new_problem_would():
    solver = c3rt.Solver(problem())
    first = solver.solve()
    other = c3rt.LCS(**random_blocks(2))
    x0, xd = np.array([0.1, 0.2, 0.3, 0.4]), np.linspace(0, 1, 24).reshape(6, 4)
    changed = solver.solve(x0=x0, lcs=other, xd=xd)
    alone = c3rt.Problem(other, x0, **parameters("C3+") | {"xd": xd}).solve()
    assert np.array_equal(changed.u, alone.u) and changed.objective == alone.objective
    each = solver.solve(x0, [other] * 5, xd)
    assert np.allclose(each.u, alone.u, atol=1e-12)
    # nothing of that is left behind
    assert np.array_equal(solver.solve().u, first.u)
    with pytest.raises(ValueError, match="^xd: "):
        solver.solve(x0=x0, lcs=other, xd=[1.0])
    for _ in range(6):
        assert np.array_equal(solver.solve(xd=np.zeros(4)).u, first.u)
    # from an earlier one it begins elsewhere
    assert not np.array_equal(solver.solve(start=first).u, first.u)


@pytest.mark.parametrize("arguments, message", [
    ({"x0": np.ones(3)}, r"^x0: expected the shape \(4,\), got \(3,\)"),
    ({"x0": [1, 2, 3, np.nan]}, "^x0: expected finite numbers, got nan"),
    ({"xd": np.ones((5, 4))}, r"^xd: expected the shape \(6, 4\), got \(5, 4\)"),
    ({"lcs": c3rt.LCS(**random_blocks(1, n_lambda=2))}, "^lcs: expected n_x 4, n_lambda 3, n_u 2, got n_x 4, n_lambda 2"),
    ({"lcs": [c3rt.LCS(**random_blocks(1))] * 4}, "^lcs: expected one LCS or a list of N = 5"),
    ({"deadline_s": -1.0}, "^deadline_s: expected a number"),
])
def test_a_solver_refuses_by_name(arguments, message):
    with pytest.raises(ValueError, match=message):
        c3rt.Solver(problem()).solve(**arguments)


def test_a_start_of_another_kind_or_size_is_refused():
    with pytest.raises(ValueError, match=r"^start: expected a result whose delta has the shape \(5, 12\), got \(5, 9\)"):
        c3rt.Solver(problem()).solve(start=problem("LCP").solve())
    with pytest.raises(ValueError, match='"MIQP15"'):
        c3rt.Solver(problem()).solve(start=problem("MIQP", method="MIQP15").solve())
    with pytest.raises(ValueError, match='^Solver: expected a problem of method "C3"'):
        c3rt.Solver(problem("MIQP", method="MIQP15"))


@pytest.mark.parametrize("changes, message", [
    ({"Q": np.eye(3)}, "^Problem: params.Q: expected 4 x 4, got 3 x 3"),
    ({"R": -np.eye(2)}, "^Problem: params.R: expected a positive semidefinite matrix"),
    ({"rhos": 1}, "^Problem: params.rhos: unknown key"),
    ({"N": 0}, "^Problem: params.N: expected an integer"),
    ({"N": 2**70}, "^Problem: params.N: expected an integer"),
    ({"xd": np.full(4, np.nan)}, "^Problem: params.xd"),
    ({"umin": np.full(2, np.inf)}, "^Problem: params.umin"),
    ({"projection": "EXACT"}, "^Problem: projection: expected"),
])
def test_a_problem_refuses_by_key(changes, message):
    with pytest.raises(ValueError, match=message):
        problem(**changes)


def test_an_infinite_bound_is_none():
    free = problem("C3+", umin=np.full(2, -np.inf), umax=[np.inf, 0.01], trace=False).solve()
    one = problem("C3+", umax=[None, 0.01], trace=False).solve()
    assert free.u[:, 1].max() <= 0.01 + 1e-8 and np.allclose(free.u, one.u)


def test_a_file_that_is_not_there_or_wrong_is_named(tmp_path):
    with pytest.raises(ValueError, match="nowhere.json: expected a file"):
        c3rt.load_problem(tmp_path / "nowhere.json")
    (tmp_path / "wrong.json").write_text(json.dumps(as_file("C3+", G=[[1]])))
    with pytest.raises(ValueError, match="wrong.json: params.G: expected"):
        c3rt.load_problem(tmp_path / "wrong.json")


def long_solver():
    """Of a solve that takes seconds."""
    return c3rt.Solver(problem("MIQP", s=100000, rho_s=1.0, N=20, trace=False))


def test_other_threads_run_during_a_solve():
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e6)  # who has the lock of Python keeps it unless it gives it away
    try:
        solver, begun, done = long_solver(), threading.Event(), []

        def solve():
            begun.set()
            done.append(solver.solve(deadline_s=0.5))

        thread = threading.Thread(target=solve)
        thread.start()
        begun.wait()
        assert not done
        thread.join()
        assert done[0].status == "truncated"
    finally:
        sys.setswitchinterval(interval)


def test_threads_may_share_a_solver():
    solver, results = c3rt.Solver(problem("MIQP")), []
    threads = [threading.Thread(target=lambda: results.append(solver.solve())) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(np.array_equal(result.u, results[0].u) for result in results)


def test_ctrl_c_ends_a_solve():
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    signal.setitimer(signal.ITIMER_REAL, 0.1)
    try:
        with pytest.raises(KeyboardInterrupt):
            long_solver().solve()
    finally:
        signal.signal(signal.SIGALRM, before)


def test_the_stubs_name_what_the_package_has():
    folder = pathlib.Path(c3rt.__file__).parent
    stubs = (folder / "_core.pyi").read_text()
    assert (folder / "py.typed").exists()
    for name in c3rt.__all__:
        of_extension = hasattr(c3rt._core, name)  # the others are Python's own, and have their types where they stand
        assert not of_extension or f"class {name}" in stubs or f"def {name}(" in stubs, name
