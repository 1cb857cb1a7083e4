import numpy as np
import pytest
from conftest import modes, random_blocks

import c3rt


@pytest.mark.parametrize("seed", range(10))
def test_a_step_is_that_of_the_mode_that_fits(seed):
    b = random_blocks(seed)
    random = np.random.default_rng(100 + seed)
    x, u = random.normal(size=4), random.normal(size=2)
    x_next, lam = c3rt.LCS(**b).step(x, u)
    expected = modes(b["F"], b["E"] @ x + b["H"] @ u + b["c"])
    assert np.allclose(lam, expected, atol=1e-9)
    assert np.allclose(x_next, b["A"] @ x + b["B"] @ u + b["D"] @ expected + b["d"], atol=1e-9)


def test_a_simulation_is_its_steps_with_one_system_or_one_for_each(blocks):
    lcs = c3rt.LCS(**blocks)
    u = np.random.default_rng(2).normal(size=(6, 2))
    x0 = np.ones(4)
    for simulation in (c3rt.simulate(lcs, x0, u), c3rt.simulate([lcs] * 6, x0, u)):
        assert simulation.ok and simulation.steps == 6 and simulation.x.shape == (7, 4)
        x = x0
        for k in range(6):
            x, lam = lcs.step(x, u[k])
            assert np.array_equal(simulation.x[k + 1], x)
            assert np.array_equal(simulation.lam[k], lam)


def test_a_simulation_ends_where_an_lcp_has_no_answer():
    # lam >= 0 with 0 lam - 1 + x >= 0: none as soon as x < 1
    lcs = c3rt.LCS([[1]], [[1]], [[0]], [0], [[1]], [[0]], [[0]], [-1])
    simulation = c3rt.simulate(lcs, [1.5], [[-0.4], [-0.4], [0.0]])
    assert not simulation.ok and simulation.steps == 2 and "Lemke" in simulation.why
    with pytest.raises(RuntimeError, match="Lemke"):
        lcs.step([0.5], [0.0])


@pytest.mark.parametrize("change", [
    np.asfortranarray,
    lambda a: np.repeat(a, 2, axis=-1)[..., ::2],  # every other number
    lambda a: a[::-1].copy()[::-1],  # from the end
    lambda a: np.broadcast_to(a, (3, *a.shape))[1],
    lambda a: a.astype(">f8"),
    lambda a: a.tolist(),
])
def test_arrays_of_any_strides_and_lists_are_the_same_numbers(blocks, change):
    lcs = c3rt.LCS(**{name: change(block) for name, block in blocks.items()})
    for name, block in blocks.items():
        assert np.array_equal(getattr(lcs, name), block), name
    x, u = np.ones(4), np.ones(2)
    assert np.array_equal(lcs.step(change(x), change(u))[0], c3rt.LCS(**blocks).step(x, u)[0])


def test_integers_and_single_precision_become_doubles(blocks):
    lcs = c3rt.LCS(**blocks | {"c": np.array([1, 2, 3]), "d": np.zeros(4, np.float32)})
    assert np.array_equal(lcs.c, [1.0, 2.0, 3.0]) and lcs.d.dtype == np.float64


def test_what_comes_out_lives_as_long_as_it_is_used_and_cannot_be_written_to(blocks):
    A = c3rt.LCS(**blocks).A
    assert np.array_equal(A, blocks["A"])
    with pytest.raises(ValueError, match="read-only"):
        A[0, 0] = 1.0


@pytest.mark.parametrize("name, value, expected, got", [
    ("A", np.ones((4, 3)), "(4, 4)", "(4, 3)"),
    ("D", np.ones((4, 2)), "(4, 3)", "(4, 2)"),
    ("d", np.ones((4, 1)), "(4,)", "(4, 1)"),
    ("c", np.ones(2), "(3,)", "(2,)"),
    ("E", np.ones(3), "(3, 4)", "(3,)"),
    ("F", 1.0, "(any, any)", "()"),
])
def test_a_wrong_shape_names_the_argument_and_both_shapes(blocks, name, value, expected, got):
    with pytest.raises(ValueError) as error:
        c3rt.LCS(**blocks | {name: value})
    assert str(error.value) == f"LCS.{name}: expected the shape {expected}, got {got}"


@pytest.mark.parametrize("value, got", [
    (np.ones((4, 4)) * 1j, "complex128"), ([["a"] * 4] * 4, "str"), ([[None] * 4] * 4, "object"), ([[1], [1, 2]], "what is none"),
    (np.full((4, 4), np.nan), "nan"), (np.full((4, 4), -np.inf), "-inf"),
])
def test_what_is_no_real_number_is_refused_by_its_name(blocks, value, got):
    with pytest.raises(ValueError, match="^LCS.A: expected .*" + got):
        c3rt.LCS(**blocks | {"A": value})


def test_states_and_inputs_are_checked_as_well(blocks):
    lcs = c3rt.LCS(**blocks)
    with pytest.raises(ValueError, match=r"^x: expected the shape \(4,\), got \(3,\)"):
        lcs.step(np.ones(3), np.ones(2))
    with pytest.raises(ValueError, match=r"^u: expected the shape \(any, 2\), got \(2, 5\)"):
        c3rt.simulate(lcs, np.ones(4), np.ones((2, 5)))
    with pytest.raises(ValueError, match=r"^u: expected the shape \(3, 2\), got \(5, 2\)"):
        c3rt.simulate([lcs] * 3, np.ones(4), np.ones((5, 2)))


def test_a_system_without_contacts_or_inputs_steps():
    lcs = c3rt.LCS(np.eye(2), np.ones((2, 0)), np.ones((2, 0)), np.ones(2), np.ones((0, 2)), np.ones((0, 0)),
                   np.ones((0, 0)), np.ones(0))
    x_next, lam = lcs.step([1, 2], [])
    assert np.array_equal(x_next, [2, 3]) and lam.shape == (0,)
