import pathlib
import re
import subprocess
import sys

import numpy as np
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]

pytest.importorskip("cyclonedds", reason="the package cyclonedds is the extra [dds]")

from cyclonedds.qos import Policy  # noqa: E402

import c3rt.v2 as types  # noqa: E402
from c3rt._core import refusal  # noqa: E402
from c3rt.client import (CartesianPose, CartesianVelocities, Client, Estimate, Estimator, JointPositions,  # noqa: E402
                         JointVelocities, Knot, Mover, NoAnswer, Planner, Thresholds, _bus, _client, _process)


def test_the_library_alone_imports_no_dds():
    words = "import sys, c3rt; sys.exit(any(name.split('.')[0] == 'cyclonedds' for name in sys.modules))"
    assert subprocess.run([sys.executable, "-c", words]).returncode == 0


def words_of(qos):
    """Of a quality of service, as docs/clients.md writes it."""
    words = ["reliable" if isinstance(qos[Policy.Reliability], Policy.Reliability.Reliable) else "best effort"]
    words.append("transient local" if qos[Policy.Durability] == Policy.Durability.TransientLocal else "volatile")
    words.append(f"keep last {qos[Policy.History].depth}")
    if qos[Policy.Deadline] is not None:
        words.append(f"deadline {qos[Policy.Deadline].deadline // 1_000_000} ms")
    if qos[Policy.Liveliness] is not None:
        words.append(f"liveliness lease {qos[Policy.Liveliness].lease_duration // 1_000_000} ms")
    return ", ".join(words)


def rows_of_the_page():
    return re.findall(r"^\| ([a-z]+(?:/[a-z]+)?) \| c3rt::v2::(\w+) \| ([^|]+) \| ([^|]+) \|$",
                      (ROOT / "docs/clients.md").read_text(), re.MULTILINE)


def test_the_topics_are_those_of_the_page():
    assert {(name, kind) for name, kind, _, _ in rows_of_the_page()} == {(t.name, t.type) for t in _bus.TOPICS.values()}


@pytest.mark.parametrize("name, kind, offered, requested", rows_of_the_page(), ids=lambda row: row if "/" in row else "")
def test_writers_offer_and_readers_request_what_the_page_says(name, kind, offered, requested):
    topic = _bus.topic_of(name)
    assert words_of(_bus.writer_qos(topic)) == offered.replace(", strength 100", "")
    # a reader may ask for less: the deadline is the service's own
    assert words_of(_bus.reader_qos(topic, depth=256 if topic.quality == "sync" else 1)) == re.sub(
        ", deadline \\d+ ms", "", requested)
    strong = _bus.writer_qos(topic, lockstep=True, process="planner")[Policy.OwnershipStrength]
    assert (strong is not None) == ("strength 100" in offered)


def test_a_topic_is_found_by_its_type_as_well():
    assert _bus.topic_of(types.Plan) is _bus.topic_of("plan")


def test_every_type_is_there_and_empty_unless_it_is_told():
    for topic in _bus.TOPICS.values():
        kind = getattr(types, topic.type)
        assert kind.deserialize(kind().serialize()) == kind()
    plan = types.Plan()
    plan.knots[0].p_WE_m[0] = 1.0
    assert plan.knots[1].p_WE_m == [0, 0, 0] and types.Plan().knots[0].p_WE_m == [0, 0, 0]


def test_a_target_has_its_parameters_as_the_page_says():
    sample = _client.target_sample("pose", {"goals_m": [[0.55, 0.05], [0.5, 0.0]], "hold_s": 1, "loop": True, "between": "t"}, 7)
    assert (sample.kind, sample.request_id, sample.parameter_count) == ("pose", 7, 4)
    goals, hold, loop, between = sample.parameters[:4]
    assert (goals.name, goals.value_count, goals.values[:5]) == ("goals_m", 4, [0.55, 0.05, 0.5, 0.0, 0.0])
    assert (hold.value_count, hold.values[0], loop.values[0]) == (1, 1.0, 1.0)
    assert (between.value_count, between.word) == (0, "t")
    assert types.TaskTarget.deserialize(sample.serialize()) == sample


def test_weights_have_the_names_of_a_scenario():
    sample = _client.weights_sample({"roll.Q.ball_xy": 2e5, "roll.R": 0.02}, 7)
    assert (sample.request_id, sample.weight_count) == (7, 2)
    assert [(weight.name, weight.value) for weight in sample.weights[:3]] == [("roll.Q.ball_xy", 2e5), ("roll.R", 0.02), ("", 0.0)]
    assert types.PlannerWeights.deserialize(sample.serialize()) == sample
    assert _client.weights_sample({}).weight_count == 0
    with pytest.raises(ValueError, match="at most 32, got 33"):
        _client.weights_sample({str(i): 1.0 for i in range(33)})
    with pytest.raises(ValueError, match="roll.R: expected a number, got"):
        _client.weights_sample({"roll.R": [1.0, 2.0]})
    with pytest.raises(TypeError, match="roll.R"):
        _client.weights_sample({"roll.R": "much"})


@pytest.mark.parametrize("call, error, message", [
    (lambda: Client(domain="0"), TypeError, "^domain: expected a whole number from 0 to 230, got '0'"),
    (lambda: Client(domain=231), ValueError, "^domain: expected a whole number from 0 to 230, got 231"),
    (lambda: Client(profile="moon"), ValueError, "^profile: expected lan, loopback or a file, got 'moon'"),
    (lambda: Client(profile=3), TypeError, "^profile: expected a name or a path, got 3"),
    (lambda: Client(profile=str(ROOT / "config/dds/secure.xml")), ValueError, "^profile: .*secure.xml wants keys"),
    (lambda: _bus.topic_of("robot/stat"), ValueError, "^topic: expected one of sim/scene, .*, got 'robot/stat'"),
    (lambda: _bus.topic_of(types.Header), ValueError, "^topic: expected a type of c3rt.v2 that a topic has, got Header"),
    (lambda: _client.target_sample("", {}), ValueError, "^kind: expected a text of 1 to 31 bytes, got ''"),
    (lambda: _client.target_sample("pose", {"goals_m": [1, None]}), TypeError, "^goals_m: expected numbers .* got None"),
    (lambda: _client.target_sample("pose", {"goals_m": [0] * 65}), ValueError, "^goals_m: expected at most 64 numbers, got 65"),
    (lambda: _client.target_sample("pose", {f"p{i}": 0 for i in range(17)}), ValueError, "^target: expected at most 16"),
    (lambda: _client.process_of("moon"), ValueError, "^process: expected one of plant, impedance, planner, vision, got 'moon'"),
    (lambda: Thresholds([20] * 6, 20).sample(), ValueError, "^collision_torque: expected 1 or 7 numbers, got 6"),
    (lambda: Client.guide(None, axes=["x", "w"]), ValueError, "^axes: expected of x, y, z, roll, pitch, yaw, got 'w'"),
    (lambda: Client.push(None, [1.0, 2.0], 0.5), ValueError, "^force: expected 3 numbers, got 2"),
    (lambda: Mover()._sample([0.0] * 7), TypeError, r"^move\(\): expected JointPositions, .*, got \[0.0"),
    (lambda: Mover()._sample(JointPositions([0.0] * 6)), ValueError, r"^q: expected the shape \(7,\), got \(6,\)"),
    (lambda: Planner().run(clock="mine"), ValueError, "^clock: expected realtime or lockstep, got 'mine'"),
    (lambda: type("P", (Planner,), {"rate_hz": 0})().run(), ValueError, "^rate_hz: expected a number from 1 to 1000, got 0"),
    (lambda: _process._vector("knots[0].p", [1, 2], 3), ValueError, r"^knots\[0\].p: expected the shape \(3,\), got \(2,\)"),
    (lambda: _process._vector("knots[0].p", [1, 2, np.nan], 3), ValueError, r"^knots\[0\].p: expected finite numbers"),
    (lambda: _process._vector("knots[0].p", "abc", 3), TypeError, r"^knots\[0\].p: expected 3 numbers, got 'abc'"),
    (lambda: _process._quaternion("q", [0, 0, 0, 0]), ValueError, "^q: expected a quaternion w x y z, got zeros"),
])
def test_what_is_wrong_is_named_with_what_was_expected(call, error, message):
    with pytest.raises(error, match=message):
        call()


def planner():
    plans = Planner()
    plans._state_now, plans._seen = types.RobotState(header=types.Header(1, 1, 40)), {}
    return plans


def test_a_plan_s_knots_are_those_that_were_said_from_when_it_takes_effect():
    plan = planner()._sample([Knot([0.5, 0, 0.1], after=0.0), Knot((0.5, 0.1, 0.1), q=[2, 0, 0, 0], after=0.05)], "roll", 1000, 0.0)
    assert (plan.knot_count, plan.phase, plan.origin.state_ns) == (2, "roll", 40)
    assert [knot.time_ns for knot in plan.knots[:2]] == [1000, 50_001_000]
    assert plan.knots[0].q_WE == [0, 1, 0, 0] and plan.knots[1].q_WE == [1, 0, 0, 0]
    assert plan.valid_until_ns == 1000 + 100_000_000


@pytest.mark.parametrize("knots, phase, error, message", [
    ([], "roll", ValueError, "expected 1 to 16 knots, got 0"),
    ([Knot([0, 0, 0], after=i) for i in range(17)], "roll", ValueError, "expected 1 to 16 knots, got 17"),
    ([Knot([0, 0, 0]), Knot([0, 0, 0])], "roll", ValueError, r"^knots\[1\].after: expected more than that before"),
    ([[0, 0, 0]], "roll", TypeError, "expected a Knot or several"),
    ([Knot([0, 0, 0])], "", ValueError, "^phase: expected a text of 1 to 31 bytes, got ''"),
])
def test_a_plan_that_cannot_be_is_refused_where_it_is_made(knots, phase, error, message):
    with pytest.raises(error, match=message):
        planner()._sample(knots, phase, 0, 0.0)


def test_an_estimate_is_an_estimate_of_an_object_that_can_be():
    sees = Estimator()
    sees._text = ""
    with pytest.raises(TypeError, match="expected a list of Estimate"):
        sees._write(0, [(0, [0, 0, 0])])
    with pytest.raises(ValueError, match="^index: expected 0 to 7, got 8"):
        sees._write(0, [Estimate(8, [0, 0, 0])])


def test_thresholds_of_contact_are_those_of_collision_unless_they_are_told():
    sample = Thresholds(20.0, [30, 30, 30, 5, 5, 6]).sample()
    assert sample.collision_torque_nm == sample.contact_torque_nm == [20.0] * 7
    assert (sample.collision_force_E_n, sample.collision_torque_E_nm) == ([30, 30, 30], [5, 5, 6])
    assert (sample.contact_force_E_n, sample.contact_torque_E_nm) == ([30, 30, 30], [5, 5, 6])
    sample = Thresholds(20.0, 30.0, range(7), 10.0).sample()
    assert sample.contact_torque_nm == [0, 1, 2, 3, 4, 5, 6] and sample.contact_torque_E_nm == [10.0] * 3
    order = types.RobotOrder(header=types.Header(0, 1, 0), kind=types.OrderKind.ORDER_THRESHOLDS, nominal=sample, acceleration=sample)
    assert refusal("robot/order", order.serialize()) == ""
    order.acceleration = Thresholds(20.0, 30.0, contact_force=31.0).sample()
    assert refusal("robot/order", order.serialize()) == "acceleration.contact_force_E_n[0] is 31, expected 0 to 30"


def test_a_motion_says_what_its_kind_says_and_no_more():
    mover = Mover()
    header = types.Header(1, 1, 10)
    for command, kind, field, numbers in (
            (JointPositions(range(7)), "JOINT_POSITION", "q_rad", [0, 1, 2, 3, 4, 5, 6]),
            (JointVelocities([0.1] * 7, True), "JOINT_VELOCITY", "dq_rad_per_s", [0.1] * 7),
            (CartesianPose([0.5, 0, 0.1], [2, 0, 0, 0], (0.0, -1)), "CARTESIAN_POSE", "q_WE", [1, 0, 0, 0]),
            (CartesianVelocities([0, 0.1, 0]), "CARTESIAN_VELOCITY", "v_WE_m_per_s", [0, 0.1, 0])):
        sample = mover._sample(command)
        sample.header = header
        assert sample.kind.name == f"MOTION_{kind}" and getattr(sample, field) == numbers
        assert sample.finished == command.finished and sample.has_elbow == (kind == "CARTESIAN_POSE")
        assert refusal("robot/motion", sample.serialize()) == ""
        expected = types.RobotMotion(header=header, kind=sample.kind, finished=sample.finished, has_elbow=sample.has_elbow,
                                     elbow_sign=sample.elbow_sign, **{field: numbers})
        if kind == "CARTESIAN_POSE":
            expected.p_WE_m, expected.elbow_sign = [0.5, 0, 0.1], -1.0
        assert sample == expected


def estimate(**fields):
    return types.ObjectEstimate(**{"header": types.Header(1, 1, 10), "q_WB": [1.0, 0.0, 0.0, 0.0], **fields})


@pytest.mark.parametrize("topic, sample, why", [
    ("object/estimate", estimate(), ""),
    ("object/estimate", estimate(q_WB=[0.0] * 4), "zero quaternion q_WB: norm 0, expected 1"),
    ("object/estimate", estimate(p_WB_m=[0.0, float("nan"), 0.0]), "p_WB_m[1] is nan, expected -10 to 10"),
    ("object/estimate", estimate(object_index=8), "object_index is 8, expected 0 to 7"),
    ("object/estimate", estimate(name="a\x1b[2J"), "name is no text: expected at most 31 printable letters and an end"),
    ("object/estimate", estimate(header=types.Header(1, 0, 10)), "header.seq is 0, expected 1 to "),
    ("object/estimate", estimate(header=types.Header(1, 1, -1)), "header.time_ns in seconds is -1e-09, expected 0 to "),
    ("plan", types.Plan(header=types.Header(1, 1, 10), valid_until_ns=20, knot_count=17), "knot_count is 17, expected 1 to 16"),
    ("plan", estimate(), "not the bytes of a sample of plan"),
])
def test_what_a_value_cannot_be_is_refused_as_by_the_processes(topic, sample, why):
    said = refusal(topic, sample.serialize())
    assert said == why or (why.endswith(" to ") and said.startswith(why))


def test_an_enumerator_that_there_is_not_is_refused_and_so_are_bytes_that_end_too_early():
    modes = [bytearray(types.RobotState(header=types.Header(1, 1, 10), mode=mode).serialize())
             for mode in (types.RobotMode.ROBOT_IDLE, types.RobotMode.ROBOT_MOVE)]
    place = next(i for i, (a, b) in enumerate(zip(*modes)) if a != b)
    modes[0][place] = 200
    assert refusal("robot/state", bytes(modes[0])) == "mode is 200, expected an enumerator, 0 to 3"
    for length in range(0, len(modes[1]) - 4, 7):
        assert refusal("robot/state", bytes(modes[1][:length])) == "not the bytes of a sample of robot/state"


def test_a_reader_gives_out_what_can_be_and_says_what_could_not():
    with Client(domain=87) as client:
        writer = _bus.Writer(client._bus, "object/estimate")
        reader = client.reader("object/estimate", depth=10)
        for _ in range(100):  # until both have found each other
            writer.write(estimate(p_WB_m=[0.1, 0.0, 0.0]), 1)
            if reader.wait(0.1):
                break
        assert [sample.p_WB_m[0] for sample in reader.take()][-1] == 0.1 and reader.refused == 0
        writer.write(estimate(p_WB_m=[11.0, 0.0, 0.0]), 2)
        writer.write(estimate(p_WB_m=[0.2, 0.0, 0.0]), 3)
        got = []
        while not got or got[-1] != 0.2:
            assert reader.wait(5.0)
            got += [sample.p_WB_m[0] for sample in reader.take()]
        assert 11.0 not in got
        if reader.refused:  # keep last 1: the one before may be gone before it is read
            assert reader.refusal == "object/estimate: p_WB_m[0] is 11, expected -10 to 10"


def test_where_nobody_writes_it_is_told_on_which_domain_and_what_to_do(monkeypatch):
    monkeypatch.setenv("CYCLONEDDS_URI", "file:///nowhere.xml")  # not read
    with Client(domain=87) as client:
        with pytest.raises(NoAnswer, match="^plan: nothing has come for 0.1 s on domain 87, profile loopback: c3rt status"):
            client.newest("plan", timeout=0.1)
        with pytest.raises(NoAnswer, match="^planner did not answer for 0.1 s on domain 87"):
            client.target("hold", timeout=0.1)
        with Client(domain=87) as other:  # one process, two clients of one domain
            assert other.status(timeout=0.1) == {}
        with pytest.raises(ValueError, match="^domain: 87 is in use in this process with another profile"):
            Client(domain=87, profile="lan")
    with pytest.raises(RuntimeError, match="closed"):
        client.reader("plan")
    client.close()
