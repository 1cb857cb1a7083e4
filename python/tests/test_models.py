import json
import os
import pathlib
import re
import subprocess

import numpy as np
import pytest

import c3rt

ROOT = pathlib.Path(__file__).resolve().parents[2]
T = ROOT / "config/objects/t.xml"
PUSHER = ROOT / "examples/pusher/pusher.xml"
CART_POLE = {"cart_mass_kg": 0.978, "pole_mass_kg": 0.411, "pole_length_m": 0.6, "center_length_m": 0.4267,
             "wall_stiffness_n_per_m": 50, "wall_distance_m": 0.35, "gravity_m_per_s2": 9.81}


@pytest.mark.parametrize("arguments, options", [
    ([T], {}),
    ([T, T], {"pairs": ["object_table", "object_object"], "contact_model": "stewart_trinkle", "step": 0.02}),
    ([PUSHER], {"support_points": 3}),
])
def test_a_model_is_what_lcs_inspect_sees(tmp_path, arguments, options):
    file = tmp_path / "problem.json"
    words = [os.environ["C3RT_PROGRAM"], "lcs", "inspect", *map(str, arguments), "--out", str(file)]
    for key, value in options.items():
        words += ["--" + key.replace("_", "-"), *(value if isinstance(value, list) else [str(value)])]
    subprocess.run(words, check=True, capture_output=True)
    expected = json.loads(file.read_text())
    seen = c3rt.lcs_from_mjcf(arguments if len(arguments) > 1 else arguments[0], **options)
    for name, block in expected["lcs"].items():
        assert np.array_equal(getattr(seen.lcs, name), block), name
    assert np.array_equal(seen.x0, expected["x0"]) and np.array_equal(seen.xd, expected["params"]["xd"])
    assert len(seen.names) == seen.lcs.n_x
    assert np.array_equal(seen.problem().solve().u, c3rt.load_problem(file).solve().u)


def test_what_lies_on_the_table_stays_and_without_the_table_falls():
    on_table = c3rt.lcs_from_mjcf(T)
    x, lam = on_table.lcs.step(on_table.x0, np.zeros(3))
    assert np.allclose(x, on_table.x0, atol=1e-9) and lam.max() > 0
    step = 0.01
    falling = c3rt.lcs_from_mjcf(T, pairs=["end_effector_object"], step=step)
    x, lam = falling.lcs.step(falling.x0, np.zeros(3))
    z = falling.names.index("object_z")
    v_z = falling.names.index("object_velocity") + 2
    assert np.isclose(x[v_z], -9.81 * step) and np.isclose(x[z], falling.x0[z] - 9.81 * step**2)
    assert not lam.any()


@pytest.mark.parametrize("arguments, message", [
    ({"path": "nowhere.xml"}, "^nowhere.xml: expected a model"),
    ({"path": []}, "^path: expected a file or several"),
    ({"path": T, "pairs": ["table"]}, "^pairs: expected pairs .* end_effector_object, object_table, .* got table"),
    ({"path": PUSHER, "pairs": ["fork,moon"]}, "moon"),
    ({"path": T, "contact_model": "glue"}, '^contact_model: expected anitescu or stewart_trinkle, got "glue"'),
    ({"path": T, "step": 0.0}, "^step: expected a number in"),
    ({"path": T, "effector": [0, 0]}, r"^effector: expected the shape \(3,\), got \(2,\)"),
    ({"path": [T, PUSHER]}, "expected one file where it has motors, got 2"),
])
def test_a_model_that_cannot_be_planned_with_is_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        c3rt.lcs_from_mjcf(**arguments)


def test_the_cart_pole_is_that_of_independent_code():
    expected = json.loads((ROOT / "tests/data/golden/cartpole.json").read_text())["lcs_const"]
    system = c3rt.System("cart_pole", **CART_POLE)
    lcs = system.lcs(np.zeros(4), 0.01)
    for name in "ABDdEFHc":
        assert np.allclose(getattr(lcs, name), expected[name], atol=1e-12), name
    assert (len(system.x_names), len(system.u_names), len(system.lam_names)) == (4, 1, 2)


def test_the_systems_have_names_and_keys():
    assert c3rt.systems() == ["cart_pole", "finger_gaiting", "pivoting"]
    assert c3rt.System.keys("cart_pole") == list(CART_POLE)
    with pytest.raises(ValueError, match='^name: expected one of cart_pole, .*, got "car"'):
        c3rt.System("car")
    with pytest.raises(ValueError, match="^wheels: unknown key, expected one of cart_mass_kg"):
        c3rt.System("cart_pole", **CART_POLE, wheels=4)
    with pytest.raises(ValueError, match=r"^pole_mass_kg: expected a number in \[.*\], got -1"):
        c3rt.System("cart_pole", **CART_POLE | {"pole_mass_kg": -1})
    with pytest.raises(ValueError, match="^pole_mass_kg: expected a number, got none"):
        c3rt.System("cart_pole", cart_mass_kg=1)
    with pytest.raises(ValueError, match=r"^x: expected the shape \(4,\)"):
        c3rt.System("cart_pole", **CART_POLE).lcs(np.zeros(3), 0.01)


def test_the_lines_of_the_readme_give_a_first_plan(monkeypatch, capsys):
    text = (ROOT / "README.md").read_text()
    lines = re.search(r"^    import c3rt\n(?:    .*\n)*", text, re.MULTILINE).group().splitlines()
    assert len(lines) == 5
    monkeypatch.chdir(ROOT)
    exec("\n".join(line.strip() for line in lines), {})
    assert capsys.readouterr().out.startswith("ok [")
