"""Prints where the end effector is: a reader of robot/state. Needs the package cyclonedds and the types of c3rt.idl."""
import os
import sys

domain = int(sys.argv[1]) if len(sys.argv) > 1 else 0
os.environ.setdefault("CYCLONEDDS_URI", "file:///usr/local/share/c3rt/config/dds/loopback.xml")

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration
from c3rt.v2 import RobotState

topic = Topic(DomainParticipant(domain), "robot/state", RobotState)
reader = DataReader(topic.participant, topic, Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(100)))
for state in reader.take_iter(timeout=duration(seconds=5)):
    print(state.header.seq, state.header.time_ns, state.p_WE_m)
