"""Systems, and a program, that the tests have in common."""

import itertools
import sys

import numpy as np
import pytest


def random_blocks(seed, n_x=4, n_lambda=3, n_u=2):
    """Blocks of an LCS whose F is positive definite, so that every LCP has one answer."""
    random = np.random.default_rng(seed)
    root = random.normal(size=(n_lambda, n_lambda))
    return {
        "A": np.eye(n_x) + 0.1 * random.normal(size=(n_x, n_x)),
        "B": random.normal(size=(n_x, n_u)),
        "D": random.normal(size=(n_x, n_lambda)),
        "d": 0.1 * random.normal(size=n_x),
        "E": random.normal(size=(n_lambda, n_x)),
        "F": root @ root.T + 0.5 * np.eye(n_lambda),
        "H": random.normal(size=(n_lambda, n_u)),
        "c": random.normal(size=n_lambda),
    }


def modes(F, q):
    """The answer of the LCP by trying which of its forces act."""
    for acting in itertools.product([False, True], repeat=len(q)):
        acting = np.array(acting)
        lam = np.zeros(len(q))
        lam[acting] = np.linalg.solve(F[np.ix_(acting, acting)], -q[acting])
        if (lam >= -1e-12).all() and (F @ lam + q >= -1e-12).all():
            return lam
    raise AssertionError("no mode fits")


def parameters(projection, n_x=4, n_lambda=3, n_u=2):
    n_z = n_x + n_lambda + n_u
    keys = {
        "projection": projection, "N": 5, "s": 4, "rho": 0.5, "rho_s": 1.5, "Q": np.eye(n_x), "QN": 3 * np.eye(n_x),
        "R": 0.1 * np.eye(n_u), "xd": np.zeros(n_x), "trace": True,
    }
    if projection == "C3+":
        return keys | {"g_lambda": 1, "g_eta": 2, "u_lambda": 3, "u_eta": 4}
    keys |= {"G": np.eye(n_z), "U": np.diag([9.0] * n_x + [1.0] * n_lambda + [2.0] * n_u)}
    if projection == "CONVEX":
        keys |= {"Qx": 9 * np.eye(n_x), "Qu": np.eye(n_u), "alpha": 0.1, "eps": 0.01}
    return keys


@pytest.fixture
def blocks():
    return random_blocks(1)


@pytest.fixture
def program(request, tmp_path):
    """A program in the place of c3rt: the text STAND_IN of the test's module."""
    file = tmp_path / "c3rt"
    file.write_text(request.module.STAND_IN.format(python=sys.executable))
    file.chmod(0o700)
    return file
