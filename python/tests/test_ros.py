"""c3rt.ros.convert: what samples of c3rt become, without a bus."""
import math

import numpy as np
import pytest

pytest.importorskip("cyclonedds", reason="the package cyclonedds could not be had")

import c3rt.v2 as v2  # noqa: E402
from c3rt.ros import convert  # noqa: E402
from c3rt.ros.messages import CUBE, CYLINDER, SPHERE, TRIANGLE_LIST, Header, PoseStamped  # noqa: E402

TURN = [math.cos(0.6), 0.0, 0.0, math.sin(0.6)]  # 1.2 rad about z


def estimate(p=(0.5, 0.1, 0.02), q=TURN, **more):
    return v2.ObjectEstimate(0, "t", p_WB_m=list(p), q_WB=list(q), valid=True, **more)


def numbers(point):
    return np.array([point.x, point.y, point.z])


def test_times_are_split_into_seconds_and_nanoseconds():
    time = convert.time_of(3_000_000_007)
    assert (time.sec, time.nanosec) == (3, 7)


def test_quaternions_change_their_order():
    pose = convert.pose(estimate(), Header()).pose
    assert (pose.orientation.w, pose.orientation.z) == (TURN[0], TURN[3])
    assert np.allclose(numbers(pose.position), [0.5, 0.1, 0.02])


@pytest.mark.parametrize("seed", range(20))
def test_a_rotation_matrix_and_its_quaternion_turn_alike(seed):
    draw = np.random.default_rng(seed)
    rotation, _ = np.linalg.qr(draw.normal(size=(3, 3)))
    rotation *= np.sign(np.linalg.det(rotation))
    if seed < 3:  # half a turn: no trace to divide by
        rotation = -np.eye(3)
        rotation[seed, seed] = 1.0
    q = convert.quaternion_of(rotation)
    for column in np.eye(3):
        assert np.allclose(convert._rotated(q, column), rotation @ column, atol=1e-12)


def test_what_is_lost_has_no_transform():
    lost = v2.ObjectEstimate(1, "ball", valid=False)
    frames = [each.child_frame_id for each in convert.transforms(v2.RobotState(), [estimate(), lost], Header()).transforms]
    assert frames == ["c3rt_end_effector", "c3rt_t_0"]


def test_parts_of_an_object_turn_with_it():
    quarter = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    shape = {"kind": "union", "parts": [{"shape": {"kind": "box", "half_sizes": [0.04, 0.01, 0.01]}, "p_BP": [0.1, 0.0, 0.0], "R_BP": quarter}]}
    marker, = convert.Looks(shape).markers(estimate(), Header())
    assert marker.type == CUBE and np.allclose(numbers(marker.scale), [0.08, 0.02, 0.02])
    assert np.allclose(numbers(marker.pose.position), [0.5 + 0.1 * math.cos(1.2), 0.1 + 0.1 * math.sin(1.2), 0.02])
    turned = 2.0 * math.atan2(marker.pose.orientation.z, marker.pose.orientation.w)
    assert turned == pytest.approx(1.2 + math.pi / 2)


def test_a_capsule_is_a_cylinder_between_two_spheres():
    markers = convert.Looks({"kind": "capsule", "radius": 0.01, "half_length": 0.05}).markers(estimate(q=[1, 0, 0, 0]), Header())
    assert [each.type for each in markers] == [CYLINDER, SPHERE, SPHERE]
    assert np.allclose(numbers(markers[0].scale), [0.02, 0.02, 0.1])
    assert [each.pose.position.z for each in markers[1:]] == [pytest.approx(-0.03), pytest.approx(0.07)]


def test_the_triangles_of_a_hull_are_its_surface_and_look_outwards():
    a, b, c = 0.02, 0.03, 0.05
    corners = [[x, y, z] for x in (-a, a) for y in (-b, b) for z in (-c, c)] + [[0.0, 0.0, 0.0]]  # one inside
    marker, = convert.Looks({"kind": "convex_mesh", "vertices": corners}).markers(estimate(), Header())
    assert marker.type == TRIANGLE_LIST
    triangles = np.array([numbers(point) for point in marker.points]).reshape(-1, 3, 3)
    crosses = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    assert 0.5 * np.linalg.norm(crosses, axis=1).sum() == pytest.approx(8 * (a * b + b * c + c * a))
    assert (np.einsum("ij,ij->i", crosses, triangles.mean(axis=1)) > 0).all()
    # the divergence theorem: the volume that the surface encloses
    assert np.einsum("ij,ij->", crosses, triangles[:, 0]) / 6 == pytest.approx(8 * a * b * c)


def test_a_goal_is_where_and_how_it_is_turned():
    message = PoseStamped(Header(frame_id="world"))
    message.pose.position.x, message.pose.position.y = 0.5, -0.1
    message.pose.orientation.w, message.pose.orientation.z = TURN[0], TURN[3]
    goal = convert.goal(message, ("panda_link0", "world"))
    assert goal["goals_m"] == [[0.5, -0.1]] and goal["yaws_rad"] == [pytest.approx(1.2)]


@pytest.mark.parametrize("change, told", [
    (lambda message: setattr(message.header, "frame_id", "map"), "frame_id: expected world, got 'map'"),
    (lambda message: setattr(message.pose.position, "y", math.nan), "pose: expected finite numbers"),
    (lambda message: setattr(message.pose.orientation, "w", 0.0), "orientation: expected a quaternion, got zeros"),
])
def test_a_goal_that_cannot_be_one_is_told(change, told):
    message = PoseStamped()
    change(message)
    with pytest.raises(convert.GoalError, match=told):
        convert.goal(message, ("world",))
