"""c3rt ros beside a run in lockstep: another participant, with ROS 2's types written here by hand, reads what it tells and gives a
goal. Run by pytest.

C3RT_PROGRAM names c3rt, PYTHONPATH has the package. The hashes are those that PyPI's rosbags 0.10 computes of Humble and of Jazzy.
"""
import os
import pathlib
import signal
import subprocess
import sys
import time
from dataclasses import dataclass, field

import pytest

pytest.importorskip("cyclonedds", reason="the package cyclonedds could not be had")

import cyclonedds.idl as idl  # noqa: E402
import cyclonedds.idl.annotations as annotate  # noqa: E402
import cyclonedds.idl.types as types  # noqa: E402
from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication  # noqa: E402
from cyclonedds.domain import DomainParticipant  # noqa: E402
from cyclonedds.pub import DataWriter  # noqa: E402
from cyclonedds.qos import Policy, Qos  # noqa: E402
from cyclonedds.sub import DataReader  # noqa: E402
from cyclonedds.topic import Topic  # noqa: E402
from cyclonedds.util import duration  # noqa: E402

from c3rt.ros import messages  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "support"))
from own_domain import take_domain  # noqa: E402

PROGRAM = os.environ["C3RT_PROGRAM"]
DOMAIN = take_domain()
ROS_DOMAIN = take_domain()
PATIENCE = 120  # of a busy machine
HASHES = {
    messages.String: "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18",
    messages.JointState: "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e",
    messages.TFMessage: "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087",
    messages.PoseStamped: "RIHS01_10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8",
    messages.MarkerArray: "RIHS01_86cb8800b6fb05b5eff1abd7a56f62a5641d3ae9a1c29e78e67e704f1d067dcf",
    messages.Clock: "RIHS01_692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564",
}


@dataclass
@annotate.final
class Stamp(idl.IdlStruct, typename="builtin_interfaces.msg.dds_.Time_"):
    sec: types.int32
    nanosec: types.uint32


@dataclass
@annotate.final
class HeaderByHand(idl.IdlStruct, typename="std_msgs.msg.dds_.Header_"):
    stamp: Stamp
    frame_id: str


@dataclass
@annotate.final
class JointStateByHand(idl.IdlStruct, typename="sensor_msgs.msg.dds_.JointState_"):
    header: HeaderByHand
    name: types.sequence[str]
    position: types.sequence[types.float64]
    velocity: types.sequence[types.float64]
    effort: types.sequence[types.float64]


@dataclass
@annotate.final
class PointByHand(idl.IdlStruct, typename="geometry_msgs.msg.dds_.Point_"):
    x: types.float64
    y: types.float64
    z: types.float64


@dataclass
@annotate.final
class QuaternionByHand(idl.IdlStruct, typename="geometry_msgs.msg.dds_.Quaternion_"):
    x: types.float64
    y: types.float64
    z: types.float64
    w: types.float64


@dataclass
@annotate.final
class PoseByHand(idl.IdlStruct, typename="geometry_msgs.msg.dds_.Pose_"):
    position: PointByHand
    orientation: QuaternionByHand


@dataclass
@annotate.final
class PoseStampedByHand(idl.IdlStruct, typename="geometry_msgs.msg.dds_.PoseStamped_"):
    header: HeaderByHand
    pose: PoseByHand


@dataclass
@annotate.final
class StringByHand(idl.IdlStruct, typename="std_msgs.msg.dds_.String_"):
    data: str = field(default="")


@pytest.fixture(autouse=True)
def runtime(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.setenv("C3RT_PYTHON", sys.executable)
    monkeypatch.setenv("CYCLONEDDS_URI", "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name='lo' multicast='true'/>"
                                         "</Interfaces></General></Domain></CycloneDDS>")


def ros_qos():
    return Qos(Policy.Reliability.Reliable(duration(milliseconds=100)), Policy.History.KeepLast(10),
               Policy.DataRepresentation(True, False))


def until(what, wait):
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        found = what()
        if found:
            return found
        time.sleep(wait)
    raise AssertionError("nothing came")


@pytest.mark.parametrize("message", HASHES)
def test_the_type_s_hash_is_that_of_ros_2(message):
    assert messages.type_hash(message) == HASHES[message]


def test_a_ros_2_program_reads_the_joints_and_gives_a_goal(tmp_path):
    run = subprocess.Popen([PROGRAM, "up", "circle_slow", "--clock", "lockstep", "--domain", str(DOMAIN), "--out", str(tmp_path / "out")],
                           stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    border = None
    try:
        assert run.wait(PATIENCE) == 0, run.stdout.read()
        border = subprocess.Popen([PROGRAM, "ros", "--domain", str(DOMAIN), "--ros-domain", str(ROS_DOMAIN)],
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        assert "/joint_states" in border.stdout.readline()
        me = DomainParticipant(ROS_DOMAIN)
        joints = DataReader(me, Topic(me, "rt/joint_states", JointStateByHand), ros_qos())
        replies = DataReader(me, Topic(me, "rt/c3rt/goal_reply", StringByHand), ros_qos())
        goals = DataWriter(me, Topic(me, "rt/goal_pose", PoseStampedByHand), ros_qos())

        state = until(lambda: joints.take(1), 0.05)[0]
        assert state.name == [f"panda_joint{i}" for i in range(1, 8)] and state.header.frame_id == "panda_link0"
        assert len(state.position) == len(state.velocity) == len(state.effort) == 7
        assert state.position[3] < -0.1  # the elbow is bent

        # a node looks for the hash in the user data of the endpoint
        endpoints = BuiltinDataReader(me, BuiltinTopicDcpsPublication)
        told = until(lambda: [e for e in endpoints.take(100) if e.topic_name == "rt/joint_states"], 0.05)[0]
        assert told.qos[Policy.Userdata].data == f"typehash={HASHES[messages.JointState]};".encode()

        def asked(x, frame):
            goals.write(PoseStampedByHand(HeaderByHand(Stamp(0, 0), frame),
                                          PoseByHand(PointByHand(x, 0.05, 0.0), QuaternionByHand(0.0, 0.0, 0.0, 1.0))))
            return until(lambda: replies.take(1), 0.05)[0].data

        until(lambda: goals.get_matched_subscriptions() and replies.get_matched_publications() or asked(0.5, "map"), 0.05)
        assert asked(0.5, "map") == "refused: frame_id: expected panda_link0 or world, got 'map'"
        assert asked(float("nan"), "").startswith("refused: pose: expected finite numbers")
        assert asked(5.0, "").startswith("refused: ")
        assert asked(0.5, "panda_link0").startswith("accepted")
    finally:
        if border is not None:
            border.send_signal(signal.SIGINT)
            assert border.wait(PATIENCE) == 0
        subprocess.run([PROGRAM, "down", "--domain", str(DOMAIN)], timeout=PATIENCE, check=False)
