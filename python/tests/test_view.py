"""c3rt.view: what the page draws from."""

import os
import pathlib
import subprocess

import numpy as np
import pytest

from c3rt.view.robot import Robot

PROGRAM = os.environ.get("C3RT_PROGRAM")


@pytest.fixture
def two_links(tmp_path):
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "tip.stl").write_text("solid tip\nendsolid tip\n")
    file = tmp_path / "urdf" / "two.urdf"
    file.parent.mkdir()
    file.write_text("""<robot name="two">
      <link name="base"/><link name="first"/>
      <link name="tip"><collision><geometry><mesh filename="package://somewhere/meshes/tip.stl"/></geometry></collision></link>
      <joint name="a" type="revolute"><parent link="base"/><child link="first"/><origin xyz="0 0 1"/><axis xyz="0 0 1"/></joint>
      <joint name="b" type="fixed"><parent link="first"/><child link="tip"/><origin xyz="2 0 0" rpy="0 0 1.5707963267948966"/></joint>
    </robot>""")
    return file


def test_a_link_is_where_the_joints_before_it_put_it(two_links):
    poses = Robot(two_links).links([np.pi / 2])
    np.testing.assert_allclose(poses["tip"][:3, 3], [0, 2, 1], atol=1e-12)
    np.testing.assert_allclose(poses["tip"][:3, :3], [[-1, 0, 0], [0, -1, 0], [0, 0, 1]], atol=1e-12)


def test_a_mesh_is_found_from_the_folders_above_the_urdf(two_links):
    robot = Robot(two_links)
    assert robot.meshes["tip"][0] == two_links.parents[1] / "meshes" / "tip.stl"
    assert "first" not in robot.meshes


@pytest.mark.skipif(not PROGRAM, reason="C3RT_PROGRAM names no c3rt that could make a recording")
def test_the_panda_s_flange_carries_the_end_effector_that_the_plant_tells(tmp_path):
    log = pytest.importorskip("c3rt.log", exc_type=ImportError)
    subprocess.run([PROGRAM, "run", "push_t", "--in-process", "--duration", "1", "--no-pictures", "--out", tmp_path / "run"],
                   capture_output=True, check=False)
    state = log.read(tmp_path / "run" / "run.mcap", topics=["robot/state"])["robot/state"]
    urdf = os.environ.get("C3RT_PANDA_URDF")
    if not urdf or not pathlib.Path(urdf).is_file():
        pytest.skip("C3RT_PANDA_URDF names no URDF")
    robot = Robot(urdf)
    offsets = []
    for i in range(0, len(state), 100):
        flange = robot.links(state.loc[i, [f"q_rad_{j}" for j in range(7)]])["panda_link7"]
        p_WE = state.loc[i, [f"p_WE_m_{j}" for j in range(3)]].to_numpy(float)
        offsets.append(flange[:3, :3].T @ (p_WE - flange[:3, 3]))
    offsets = np.array(offsets)
    assert np.ptp(offsets, axis=0).max() < 1e-9
    np.testing.assert_allclose(offsets[0][:2], 0, atol=1e-9)  # along the flange's axis
