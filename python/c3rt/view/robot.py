"""Where the links of an arm are, from its URDF: for pictures, so that the model of the planner is not asked."""

from __future__ import annotations

import pathlib
import xml.etree.ElementTree as ElementTree
from typing import Dict, List, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np


class _Joint(NamedTuple):
    parent: str
    child: str
    fixed: np.ndarray  # 4 x 4, from the parent's frame to the joint's at angle 0
    axis: Optional[np.ndarray]  # None: does not turn


def _numbers(text: Optional[str], default: str) -> np.ndarray:
    return np.array([float(word) for word in (text or default).split()])


def turn(axis: np.ndarray, angle: float) -> np.ndarray:
    """A rotation about an axis of length 1 [rad]."""
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def _pose(origin: Optional[ElementTree.Element]) -> np.ndarray:
    pose = np.eye(4)
    if origin is not None:
        roll, pitch, yaw = _numbers(origin.get("rpy"), "0 0 0")
        x, y, z = np.eye(3)
        pose[:3, :3] = turn(z, yaw) @ turn(y, pitch) @ turn(x, roll)
        pose[:3, 3] = _numbers(origin.get("xyz"), "0 0 0")
    return pose


class Robot:
    """The links of a URDF and their meshes (those for collisions, which are small)."""

    def __init__(self, urdf: Union[str, "pathlib.Path"]) -> None:
        file = pathlib.Path(urdf)
        root = ElementTree.parse(file).getroot()
        self._joints: List[_Joint] = []
        for joint in root.findall("joint"):
            axis = joint.find("axis")
            turns = joint.get("type") in ("revolute", "continuous")
            self._joints.append(_Joint(joint.find("parent").get("link"), joint.find("child").get("link"),  # type: ignore[union-attr]
                                       _pose(joint.find("origin")),
                                       _numbers(axis.get("xyz") if axis is not None else None, "1 0 0") if turns else None))
        self.meshes: Dict[str, Tuple[pathlib.Path, np.ndarray]] = {}  # by link: file, and where it is in the link's frame
        for link in root.findall("link"):
            for collision in link.findall("collision"):
                mesh = collision.find("geometry/mesh")
                found = None if mesh is None else _found(file, mesh.get("filename", ""))
                if found is not None:
                    self.meshes[link.get("name", "")] = (found, _pose(collision.find("origin")))

    def links(self, q: Sequence[float]) -> Dict[str, np.ndarray]:
        """The pose of each link in the base's frame, 4 x 4. q: of the turning joints in the file's order [rad]"""
        children = {joint.child for joint in self._joints}
        poses = {joint.parent: np.eye(4) for joint in self._joints if joint.parent not in children}
        angles = iter(q)
        for joint in self._joints:  # a parent stands before its children, as in every URDF that xacro writes
            pose = poses[joint.parent] @ joint.fixed
            if joint.axis is not None:
                moved = np.eye(4)
                moved[:3, :3] = turn(joint.axis, next(angles, 0.0))
                pose = pose @ moved
            poses[joint.child] = pose
        return poses


def _found(urdf: pathlib.Path, name: str) -> Optional[pathlib.Path]:
    """The file of package://…/meshes/…: from the first folder above the URDF in which the path's end is."""
    parts = pathlib.PurePosixPath(name.split("://")[-1]).parts
    for folder in urdf.resolve().parents[:3]:
        for begin in range(len(parts)):
            candidate = folder.joinpath(*parts[begin:])
            if candidate.is_file():
                return candidate
    return None
