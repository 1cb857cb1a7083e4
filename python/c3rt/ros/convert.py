"""What a sample of c3rt says, as ROS 2's messages: functions without a bus. Poses are in W, the robot's base frame."""

from __future__ import annotations

import math
from typing import Any, Dict, Iterable, List, Sequence

import numpy as np

from .messages import (CUBE, CYLINDER, LINE_STRIP, SPHERE, TRIANGLE_LIST, ColorRGBA, Header, JointState, Marker, Point, Pose,
                       PoseStamped, Quaternion, TFMessage, Time, Transform, TransformStamped, Vector3)

JOINTS = [f"panda_joint{i}" for i in range(1, 8)]
EFFECTOR = "c3rt_end_effector"
OBJECT_COLOR = ColorRGBA(0.2, 0.55, 0.9, 0.9)
PLAN_COLOR = ColorRGBA(1.0, 0.6, 0.1, 1.0)
TARGET_COLOR = ColorRGBA(0.2, 0.8, 0.3, 0.6)
PLAN_WIDTH = 0.003  # [m]
TARGET_SIZE = 0.015  # [m]


class GoalError(ValueError):
    """A goal that cannot be one; the text says what was expected and what came."""


def time_of(time_ns: int) -> Time:
    return Time(time_ns // 1_000_000_000, time_ns % 1_000_000_000)


def _point(p: Sequence[float]) -> Point:
    return Point(float(p[0]), float(p[1]), float(p[2]))


def _quaternion(q: Sequence[float]) -> Quaternion:
    """From w x y z; of zeros, which tell nothing, no rotation."""
    if not any(q):
        return Quaternion()
    return Quaternion(float(q[1]), float(q[2]), float(q[3]), float(q[0]))


def _transform(header: Header, child: str, p: Sequence[float], q: Sequence[float]) -> TransformStamped:
    return TransformStamped(header, child, Transform(Vector3(float(p[0]), float(p[1]), float(p[2])), _quaternion(q)))


def joint_state(state: Any, header: Header) -> JointState:
    """Of a robot/state; effort is without gravity."""
    return JointState(header, list(JOINTS), list(state.q_rad), list(state.dq_rad_per_s), list(state.tau_nm))


def transforms(state: Any, estimates: Iterable[Any], header: Header) -> TFMessage:
    """Where the end effector's centre and the objects that are seen are."""
    return TFMessage([_transform(header, EFFECTOR, state.p_WE_m, state.q_WE)]
                     + [_transform(header, frame_of(estimate), estimate.p_WB_m, estimate.q_WB)
                        for estimate in estimates if estimate.valid])


def frame_of(estimate: Any) -> str:
    """tf2 takes any text; a topic's name would not."""
    return f"c3rt_{estimate.name or 'object'}_{estimate.object_index}"


def pose(estimate: Any, header: Header) -> PoseStamped:
    return PoseStamped(header, Pose(_point(estimate.p_WB_m), _quaternion(estimate.q_WB)))


def _rotated(q: Sequence[float], p: Sequence[float]) -> np.ndarray:
    w, v = float(q[0]), np.asarray(q[1:], dtype=float)
    t = 2.0 * np.cross(v, np.asarray(p, dtype=float))
    return np.asarray(p, dtype=float) + w * t + np.cross(v, t)


def _times(a: Sequence[float], b: Sequence[float]) -> List[float]:
    """The product of two quaternions w x y z."""
    aw, av, bw, bv = a[0], np.asarray(a[1:]), b[0], np.asarray(b[1:])
    return [float(aw * bw - av @ bv), *(float(number) for number in aw * bv + bw * av + np.cross(av, bv))]


def quaternion_of(rows: Sequence[Sequence[float]]) -> List[float]:
    """w x y z of a rotation matrix."""
    r = np.asarray(rows, dtype=float)
    # each entry's square from the diagonal; the largest one is divided by
    squares = 1.0 + np.array([r[0, 0] + r[1, 1] + r[2, 2], r[0, 0] - r[1, 1] - r[2, 2],
                              r[1, 1] - r[0, 0] - r[2, 2], r[2, 2] - r[0, 0] - r[1, 1]])
    rows_of = [[squares[0], r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]],
               [r[2, 1] - r[1, 2], squares[1], r[0, 1] + r[1, 0], r[0, 2] + r[2, 0]],
               [r[0, 2] - r[2, 0], r[0, 1] + r[1, 0], squares[2], r[1, 2] + r[2, 1]],
               [r[1, 0] - r[0, 1], r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], squares[3]]]
    q = np.array(rows_of[int(np.argmax(squares))])
    return [float(number) for number in q / np.linalg.norm(q)]


def _hull_triangles(vertices: Sequence[Sequence[float]]) -> List[Point]:
    """Of a convex mesh, corner by corner. Each plane through three corners that has all others on one side is a face."""
    corners = np.asarray(vertices, dtype=float)
    size = float(np.abs(corners - corners.mean(axis=0)).max())
    points: List[Point] = []
    seen: List[np.ndarray] = []
    for i in range(len(corners)):
        for j in range(i + 1, len(corners)):
            for k in range(j + 1, len(corners)):
                normal = np.cross(corners[j] - corners[i], corners[k] - corners[i])
                length = float(np.linalg.norm(normal))
                if length < 1e-9 * size * size:
                    continue
                beyond = (corners - corners[i]) @ (normal / length)
                if beyond.max() > 1e-6 * size:
                    normal, beyond = -normal, -beyond
                if beyond.max() > 1e-6 * size:
                    continue
                normal = normal / length
                plane = np.append(normal, normal @ corners[i])
                if any(np.abs(plane - other).max() < 1e-5 * max(1.0, size) for other in seen):
                    continue
                seen.append(plane)
                face = corners[beyond > -1e-6 * size]
                middle = face.mean(axis=0)
                along = (face[0] - middle) / np.linalg.norm(face[0] - middle)
                across = np.cross(normal, along)
                order = np.argsort(np.arctan2((face - middle) @ across, (face - middle) @ along))
                face = face[order]
                for n in range(1, len(face) - 1):
                    points += [_point(face[0]), _point(face[n]), _point(face[n + 1])]
    return points


class Looks:
    """An object's shape, as `c3rt ros` is given it, as markers in the object's frame."""

    def __init__(self, shape: Dict[str, Any]) -> None:
        self._parts: List[Dict[str, Any]] = []
        self._add(shape, [0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0])

    def _add(self, shape: Dict[str, Any], p: Sequence[float], q: Sequence[float]) -> None:
        def put(kind: int, scale: Sequence[float], at: Sequence[float] = (0.0, 0.0, 0.0), points: Any = ()) -> None:
            self._parts.append({"type": kind, "p": np.asarray(p) + _rotated(q, at), "q": q, "points": list(points),
                                "scale": Vector3(*map(float, scale))})

        kind = shape["kind"]
        across = 2 * shape.get("radius", 0.0)
        if kind == "sphere":
            put(SPHERE, [across] * 3)
        elif kind == "box":
            put(CUBE, [2 * half for half in shape["half_sizes"]])
        elif kind in ("cylinder", "capsule"):
            half = shape["half_length"]
            put(CYLINDER, [across, across, 2 * half])
            if kind == "capsule":
                for end in (-half, half):
                    put(SPHERE, [across] * 3, (0.0, 0.0, end))
        elif kind == "convex_mesh":
            put(TRIANGLE_LIST, [1.0] * 3, points=_hull_triangles(shape["vertices"]))
        elif kind == "union":
            for part in shape["parts"]:
                self._add(part["shape"], np.asarray(p) + _rotated(q, part["p_BP"]), _times(q, quaternion_of(part["R_BP"])))
        else:
            raise ValueError(f"kind: expected a shape, got {kind!r}")

    def markers(self, estimate: Any, header: Header) -> List[Marker]:
        out = []
        for number, part in enumerate(self._parts):
            at = np.asarray(estimate.p_WB_m) + _rotated(estimate.q_WB, part["p"])
            out.append(Marker(header, frame_of(estimate), number, part["type"],
                              pose=Pose(_point(at), _quaternion(_times(estimate.q_WB, part["q"]))), scale=part["scale"],
                              color=OBJECT_COLOR, points=part["points"]))
        return out


def plan_marker(plan: Any, state: Any, header: Header) -> Marker:
    """From where the end effector is along the knots."""
    knots = [_point(knot.p_WE_m) for knot in plan.knots[: plan.knot_count]]
    return Marker(header, "plan", 0, LINE_STRIP, scale=Vector3(PLAN_WIDTH, 0.0, 0.0), color=PLAN_COLOR,
                  points=[_point(state.p_WE_m), *knots])


def target_marker(debug: Any, header: Header) -> Marker:
    """Where the planner wants its object next."""
    return Marker(header, "target", 0, SPHERE, pose=Pose(_point(debug.p_WB_target_m)), scale=Vector3(*[TARGET_SIZE] * 3),
                  color=TARGET_COLOR)


def goal(message: PoseStamped, frames: Sequence[str]) -> Dict[str, Any]:
    """The parameters of a task `pose`: where on the table, and how it is turned about z. @raises GoalError"""
    frame = message.header.frame_id
    if frame and frame not in frames:
        raise GoalError(f"frame_id: expected {' or '.join(frames)}, got {frame[:60]!r}")
    at, q = message.pose.position, message.pose.orientation
    numbers = [at.x, at.y, q.x, q.y, q.z, q.w]
    if not all(math.isfinite(number) for number in numbers):
        raise GoalError(f"pose: expected finite numbers, got {numbers}")
    if q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w < 1e-6:
        raise GoalError("orientation: expected a quaternion, got zeros")
    yaw = math.atan2(2.0 * (q.w * q.z + q.x * q.y), q.w * q.w + q.x * q.x - q.y * q.y - q.z * q.z)
    return {"goals_m": [[at.x, at.y]], "yaws_rad": [yaw]}
