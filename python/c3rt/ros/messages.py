"""ROS 2's messages as they cross DDS: names, fields and type hashes.

A hash is SHA-256 of the type's description as REP-2016 writes it; a node shows it in the user data of its endpoints (REP-2011).
"""
import hashlib
import json
import typing
from dataclasses import dataclass, field
from typing import Any, Dict, List, Tuple, Type

import cyclonedds.idl as idl
import cyclonedds.idl.annotations as annotate
import cyclonedds.idl.types as types

# annotations are read at run time: no `from __future__ import annotations` in this file


@dataclass
@annotate.final
class Time(idl.IdlStruct, typename="builtin_interfaces.msg.dds_.Time_"):
    sec: types.int32 = 0
    nanosec: types.uint32 = 0


@dataclass
@annotate.final
class Duration(idl.IdlStruct, typename="builtin_interfaces.msg.dds_.Duration_"):
    sec: types.int32 = 0
    nanosec: types.uint32 = 0


@dataclass
@annotate.final
class Header(idl.IdlStruct, typename="std_msgs.msg.dds_.Header_"):
    stamp: Time = field(default_factory=Time)
    frame_id: str = ""


@dataclass
@annotate.final
class String(idl.IdlStruct, typename="std_msgs.msg.dds_.String_"):
    data: str = ""


@dataclass
@annotate.final
class ColorRGBA(idl.IdlStruct, typename="std_msgs.msg.dds_.ColorRGBA_"):
    r: types.float32 = 0.0
    g: types.float32 = 0.0
    b: types.float32 = 0.0
    a: types.float32 = 0.0


@dataclass
@annotate.final
class Clock(idl.IdlStruct, typename="rosgraph_msgs.msg.dds_.Clock_"):
    clock: Time = field(default_factory=Time)


@dataclass
@annotate.final
class JointState(idl.IdlStruct, typename="sensor_msgs.msg.dds_.JointState_"):
    header: Header = field(default_factory=Header)
    name: types.sequence[str] = field(default_factory=list)
    position: types.sequence[types.float64] = field(default_factory=list)
    velocity: types.sequence[types.float64] = field(default_factory=list)
    effort: types.sequence[types.float64] = field(default_factory=list)


@dataclass
@annotate.final
class CompressedImage(idl.IdlStruct, typename="sensor_msgs.msg.dds_.CompressedImage_"):
    header: Header = field(default_factory=Header)
    format: str = ""
    data: types.sequence[types.uint8] = field(default_factory=list)


@dataclass
@annotate.final
class Vector3(idl.IdlStruct, typename="geometry_msgs.msg.dds_.Vector3_"):
    x: types.float64 = 0.0
    y: types.float64 = 0.0
    z: types.float64 = 0.0


@dataclass
@annotate.final
class Point(idl.IdlStruct, typename="geometry_msgs.msg.dds_.Point_"):
    x: types.float64 = 0.0
    y: types.float64 = 0.0
    z: types.float64 = 0.0


@dataclass
@annotate.final
class Quaternion(idl.IdlStruct, typename="geometry_msgs.msg.dds_.Quaternion_"):
    x: types.float64 = 0.0
    y: types.float64 = 0.0
    z: types.float64 = 0.0
    w: types.float64 = 1.0


@dataclass
@annotate.final
class Transform(idl.IdlStruct, typename="geometry_msgs.msg.dds_.Transform_"):
    translation: Vector3 = field(default_factory=Vector3)
    rotation: Quaternion = field(default_factory=Quaternion)


@dataclass
@annotate.final
class TransformStamped(idl.IdlStruct, typename="geometry_msgs.msg.dds_.TransformStamped_"):
    header: Header = field(default_factory=Header)
    child_frame_id: str = ""
    transform: Transform = field(default_factory=Transform)


@dataclass
@annotate.final
class Pose(idl.IdlStruct, typename="geometry_msgs.msg.dds_.Pose_"):
    position: Point = field(default_factory=Point)
    orientation: Quaternion = field(default_factory=Quaternion)


@dataclass
@annotate.final
class PoseStamped(idl.IdlStruct, typename="geometry_msgs.msg.dds_.PoseStamped_"):
    header: Header = field(default_factory=Header)
    pose: Pose = field(default_factory=Pose)


@dataclass
@annotate.final
class TFMessage(idl.IdlStruct, typename="tf2_msgs.msg.dds_.TFMessage_"):
    transforms: types.sequence[TransformStamped] = field(default_factory=list)


@dataclass
@annotate.final
class UVCoordinate(idl.IdlStruct, typename="visualization_msgs.msg.dds_.UVCoordinate_"):
    u: types.float32 = 0.0
    v: types.float32 = 0.0


@dataclass
@annotate.final
class MeshFile(idl.IdlStruct, typename="visualization_msgs.msg.dds_.MeshFile_"):
    filename: str = ""
    data: types.sequence[types.uint8] = field(default_factory=list)


@dataclass
@annotate.final
class Marker(idl.IdlStruct, typename="visualization_msgs.msg.dds_.Marker_"):
    header: Header = field(default_factory=Header)
    ns: str = ""
    id: types.int32 = 0
    type: types.int32 = 0
    action: types.int32 = 0
    pose: Pose = field(default_factory=Pose)
    scale: Vector3 = field(default_factory=Vector3)
    color: ColorRGBA = field(default_factory=ColorRGBA)
    lifetime: Duration = field(default_factory=Duration)
    frame_locked: bool = False
    points: types.sequence[Point] = field(default_factory=list)
    colors: types.sequence[ColorRGBA] = field(default_factory=list)
    texture_resource: str = ""
    texture: CompressedImage = field(default_factory=CompressedImage)
    uv_coordinates: types.sequence[UVCoordinate] = field(default_factory=list)
    text: str = ""
    mesh_resource: str = ""
    mesh_file: MeshFile = field(default_factory=MeshFile)
    mesh_use_embedded_materials: bool = False


@dataclass
@annotate.final
class MarkerArray(idl.IdlStruct, typename="visualization_msgs.msg.dds_.MarkerArray_"):
    markers: types.sequence[Marker] = field(default_factory=list)


# Marker.type
CUBE, SPHERE, CYLINDER, LINE_STRIP, TRIANGLE_LIST = 1, 2, 3, 4, 11

_BASE = {types.uint8: 3, types.int32: 6, types.uint32: 7, types.float32: 10, types.float64: 11, bool: 15, str: 17}
_NESTED = 1
_UNBOUNDED = 144  # what a sequence adds to the number of its elements' type


def ros_name(message: Type[Any]) -> str:
    """sensor_msgs/msg/JointState"""
    package, kind, _, name = message.__idl_typename__.split(".")
    return f"{package}/{kind}/{name.rstrip('_')}"


def _field_type(annotation: Any) -> Tuple[Dict[str, Any], List[Type[Any]]]:
    """Of a description, and the messages that it names."""
    more = 0
    origin = typing.get_args(annotation)
    if origin and typing.get_origin(origin[0]) is not None:  # a sequence: Annotated[Sequence[element], ...]
        more, annotation = _UNBOUNDED, typing.get_args(origin[0])[0]
    base = _BASE.get(annotation)
    nested = "" if base is not None else ros_name(annotation)
    described = {"type_id": more + (base or _NESTED), "capacity": 0, "string_capacity": 0, "nested_type_name": nested}
    return described, [] if base is not None else [annotation]


def _description(message: Type[Any]) -> Tuple[Dict[str, Any], List[Type[Any]]]:
    fields, named = [], []
    for name, annotation in typing.get_type_hints(message, include_extras=True).items():
        described, of_it = _field_type(annotation)
        fields.append({"name": name, "type": described})
        named += of_it
    return {"type_name": ros_name(message), "fields": fields}, named


def type_hash(message: Type[Any]) -> str:
    """RIHS01_ and 64 hexadecimal digits."""
    described, waiting = _description(message)
    referenced: Dict[str, Any] = {}
    while waiting:
        other = waiting.pop()
        if ros_name(other) not in referenced:
            referenced[ros_name(other)], named = _description(other)
            waiting += named
    whole = {"type_description": described, "referenced_type_descriptions": [referenced[name] for name in sorted(referenced)]}
    return "RIHS01_" + hashlib.sha256(json.dumps(whole).encode()).hexdigest()
