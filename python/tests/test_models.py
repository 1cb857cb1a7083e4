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
    with pytest.raises(ValueError, match="^pole_mass_kg: expected a value, got none"):
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


MJCF = {"end_effector_mass_kg": 1, "end_effector_radius_m": 0.0195, "table_height_m": 0, "friction_end_effector": 0.5,
        "friction_table": 0.4, "friction_objects": 0.3, "support_points": 4, "objects": T}
BALL = {"end_effector_mass_kg": 1, "end_effector_radius_m": 0.02, "ball_mass_kg": 0.3, "ball_radius_m": 0.03,
        "table_height_m": 0, "friction_end_effector": 0.5, "friction_table": 0.4}


def test_the_planning_models_have_names():
    assert c3rt.planning_models() == ["rolling_ball", "rolling_balls", "pushed_box", "mjcf"]
    assert c3rt.PlanningModel.keys("rolling_ball") == list(BALL)


def test_a_ball_rolls_without_sliding_when_it_is_pushed_and_stays_when_it_is_not():
    ball = c3rt.PlanningModel("rolling_ball", **BALL)
    assert ball.pairs == ["end_effector_ball", "ball_table"]
    behind = [0.5 - 0.05, 0.0, 0.03]  # touches it
    scene = {"effector": behind, "positions": [[0.5, 0.0, 0.03]]}
    x0 = ball.state(**scene)
    lcs = ball.lcs(**scene, step=0.01)
    weight = 9.81  # of the end effector, which u carries here
    x, lam = lcs.step(x0, [0.0, 0.0, weight])
    assert np.allclose(x, x0, atol=1e-9)
    x, lam = lcs.step(x0, [1.0, 0.0, weight])
    n_v = 9  # v = [v_WE; omega_WB; v_WB]
    v_E, omega, v_B = np.split(x[-n_v:], 3)
    assert v_E[0] > 0 and v_B[0] > 0 and omega[1] > 0
    assert np.isclose(v_B[0], 0.03 * omega[1])  # it rolls
    # pushed by 1 N for 0.01 s: what moves has the momentum of that less what the table's friction took
    taken = 0.01 - (1.0 * v_E[0] + 0.3 * v_B[0])
    assert -1e-9 <= taken <= 0.4 * 0.3 * 9.81 * 0.01 + 1e-6


def test_a_planning_model_of_a_file_is_what_lcs_from_mjcf_has_there():
    seen = c3rt.lcs_from_mjcf(T)
    model = c3rt.PlanningModel("mjcf", **{key: value for key, value in MJCF.items()
                                          if key in c3rt.PlanningModel.keys("mjcf")})
    scene = {"effector": seen.x0[:3], "positions": [seen.x0[3:6]]}
    assert np.allclose(model.state(**scene), seen.x0, atol=1e-15)
    lcs = model.lcs(**scene, step=0.05)
    for name in "ABDdEFHc":
        assert np.allclose(getattr(lcs, name), getattr(seen.lcs, name), atol=1e-12), name
    turned = model.lcs(**scene, step=0.05, orientations=[[0, 0, 0, 1]], pairs=["object_table"])
    assert turned.n_lambda == 16 and model.lcs(**scene, step=0.05, contact_model="stewart_trinkle").n_lambda == 30


@pytest.mark.parametrize("call, message", [
    (lambda: c3rt.PlanningModel("cube"), 'expected one of rolling_ball, .*, got "cube"'),
    (lambda: c3rt.PlanningModel("rolling_ball", bodies=2, **BALL), "^bodies: expected 1 to 1 of rolling_ball, got 2"),
    (lambda: c3rt.PlanningModel("rolling_ball", **BALL, color=1), "^color: unknown key, expected one of end_effector_mass"),
    (lambda: c3rt.PlanningModel("rolling_ball", **BALL | {"ball_mass_kg": "1"}), r"^ball_mass_kg: expected a number in"),
    (lambda: c3rt.PlanningModel("mjcf", **MJCF | {"objects": "nowhere.xml"}), "nowhere.xml: expected a model"),
    (lambda: c3rt.PlanningModel("mjcf", **MJCF | {"objects": [T, T]}), "^objects: expected one file, or one for each of 1"),
    (lambda: c3rt.PlanningModel("rolling_ball", **BALL).lcs([0, 0], [[0, 0, 0]], 0.1), r"^effector: expected the shape"),
    (lambda: c3rt.PlanningModel("rolling_ball", **BALL).state([0, 0, 0], [0, 0, 0]), r"^positions: expected the shape \(1, 3\)"),
    (lambda: c3rt.PlanningModel("rolling_ball", **BALL).lcs([0, 0, 0], [[1, 0, 0]], 0.1, pairs=["sun"]), '^pairs: .*"sun"'),
    (lambda: c3rt.PlanningModel("rolling_ball", **BALL).lcs([0, 0, 0], [[1, 0, 0]], 0.1, orientations=[[0, 0, 0, 0]]),
     "^orientations: expected a quaternion"),
])
def test_a_planning_model_refuses_by_name(call, message):
    with pytest.raises(ValueError, match=message):
        call()
