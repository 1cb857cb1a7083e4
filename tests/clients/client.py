"""One cell of the matrix of docs/clients.md, in Python with PyPI's cyclonedds alone (0.10 and 11): reads robot/state for a second
and a plan, gives the planner a circle, and says what came. PYTHONPATH has the types that idl/generate.py makes.

    client.py DOMAIN
"""
import sys
import time

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from c3rt.v2 import Header, Plan, RobotState, ServiceReply, TargetParameter, TaskTarget

RELIABLE = Policy.Reliability.Reliable(duration(milliseconds=100))


def taken(of, count=100):
    return [sample for sample in of.take(count) if hasattr(sample, "header")]


def circle(request):
    def parameter(name, *values):
        return TargetParameter(name, "", len(values), list(values) + [0.0] * (64 - len(values)))

    asked = [parameter("center_m", 0.55, 0.0), parameter("radius_m", 0.08), parameter("lead_rad", 0.349)]
    return TaskTarget(Header(0, 1, 0), request, "circle", len(asked), asked + [parameter("")] * 13)


def main(domain):
    """What it has is gone when it returns: on a secure bus OpenSSL must not end before."""
    participant = DomainParticipant(domain)

    def reader(name, kind, reliability):
        return DataReader(participant, Topic(participant, name, kind), Qos(reliability, Policy.History.KeepLast(100)))

    states = reader("robot/state", RobotState, Policy.Reliability.BestEffort)
    plans, replies = reader("plan", Plan, RELIABLE), reader("service/reply", ServiceReply, RELIABLE)
    targets = DataWriter(participant, Topic(participant, "task/target", TaskTarget),
                         Qos(RELIABLE, Policy.Durability.TransientLocal))
    seqs, phase, until = [], "", time.monotonic() + 15
    while time.monotonic() < until and not (len(seqs) >= 1000 and phase):
        seqs += [state.header.seq for state in taken(states)]
        if not phase:  # one is enough: with all 200 a second Python would have no time left for the states
            phase = "".join(plan.phase for plan in taken(plans, 1))
        time.sleep(0.001)

    request = time.monotonic_ns()
    targets.write(circle(request))
    came = f"{len(seqs)} states of {seqs[-1] - seqs[0] + 1 if seqs else 0}, plan \"{phase}\""
    until = time.monotonic() + 10
    while time.monotonic() < until:
        for reply in taken(replies):
            if reply.request_id == request:
                print(f"{came}, {'ok' if reply.ok else 'refused'}: {reply.text}")
                return 0 if len(seqs) >= 100 and phase and reply.ok else 1
        time.sleep(0.005)
    print(f"{came}, no reply")
    return 1


if __name__ == "__main__":
    status = main(int(sys.argv[1]))
    sys.exit(status)
