"""A run's recording, read by PyPI's mcap and Cyclone's Python types: python mcap_reader_test.py C3RT TYPES"""
import csv
import json
import math
import pathlib
import subprocess
import sys
import tempfile

SKIPPED = 77
try:
    from mcap.reader import NonSeekingReader, make_reader
except ImportError as missing:
    print(f"skipped: {missing} (cmake/third_party.sh could not get it)")
    sys.exit(SKIPPED)
command, types = sys.argv[1:]
sys.path.insert(0, types)
import c3rt.v2 as v2  # noqa: E402  generated from idl/c3rt.idl


def c3rt(*words):
    done = subprocess.run([command, *map(str, words)], capture_output=True, text=True)
    assert done.returncode in (0, 1), done.stderr  # 1: two seconds are too short for the criteria
    return done.stdout


def check(what, condition):
    if not condition:
        sys.exit(f"not so: {what}")


with tempfile.TemporaryDirectory() as folder:
    run = pathlib.Path(folder) / "run"
    c3rt("run", "circle_slow", "--in-process", "--duration", 2, "--no-pictures", "--out", run)
    file = run / "run.mcap"
    report = json.loads((run / "report.json").read_text())

    with file.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        # as they came: several processes write service/status, and what came first need not be of the earlier time
        messages = [(schema, channel, message) for schema, channel, message in reader.iter_messages(log_time_order=False)]
        attachments = {a.name: a.data.decode() for a in reader.iter_attachments()}
        metadata = {m.name: m.metadata for m in reader.iter_metadata()}
    counts = {summary.channels[key].topic: count for key, count in summary.statistics.channel_message_counts.items()}
    check("all messages are counted", sum(counts.values()) == len(messages) == summary.statistics.message_count)
    check("a state each millisecond", 1999 <= counts["robot/state"] <= 2021)
    check("what it is a run of", metadata["run"]["scenario"] == "circle_slow" and metadata["run"]["seed"] == "1")
    check("how it ended", metadata["result"]["result"] == report["result"])
    check("the scenario, whole", "extends" not in attachments["scenario.yaml"] and "task:" in attachments["scenario.yaml"])
    check("the report", json.loads(attachments["report.json"]) == report)
    with file.open("rb") as stream:
        check("it can be read without its index",
              len(list(NonSeekingReader(stream, validate_crcs=True).iter_messages())) == len(messages))

    # every sample is of the type that its schema names, and says what our own tables say
    c3rt("export", file, "--out", run / "tables")
    rows = {}
    for schema, channel, message in messages:
        check("the schema is our IDL", schema.encoding == "omgidl" and b"struct RobotState" in schema.data)
        check("as on the wire", channel.message_encoding == "cdr" and message.data[:2] == b"\0\1")
        sample = getattr(v2, schema.name.split("::")[-1]).deserialize(message.data)
        check("times are the samples'", message.log_time == message.publish_time == sample.header.time_ns)
        check("numbers are the samples'", message.sequence == sample.header.seq)
        rows.setdefault(channel.topic, []).append(sample)
    for topic, samples in rows.items():
        with (run / "tables" / (topic.replace("/", "_") + ".csv")).open() as table:
            lines = list(csv.DictReader(table))
        check(f"{topic}: a row a sample", len(lines) == len(samples))
        check(f"{topic}: in order", [int(line["seq"]) for line in lines] == [s.header.seq for s in samples])
    with (run / "tables" / "robot_state.csv").open() as table:
        for line, sample in zip(csv.DictReader(table), rows["robot/state"]):
            for joint in range(7):
                check("joint angles", math.isclose(float(line[f"q_rad_{joint}"]), sample.q_rad[joint], rel_tol=1e-8))
            check("mode", int(line["mode"]) == sample.mode.value)

    c3rt("report", file, "--out", run / "again")
    check("the report of the recording is that of the run", json.loads((run / "again" / "report.json").read_text()) == report)

    # somebody's own object beside their scenario is found wherever the report is asked for
    root = pathlib.Path(__file__).resolve().parents[3]
    own = pathlib.Path(folder) / "own"
    own.mkdir()
    (own / "mine.xml").write_text((root / "config/objects/t.xml").read_text())
    scenario = (root / "config/scenarios/push_t.yaml").read_text().replace("../objects/t.xml", "mine.xml")
    (own / "mine.yaml").write_text(scenario)
    c3rt("run", own / "mine.yaml", "--in-process", "--duration", 0.2, "--no-pictures", "--out", run / "own")
    check("the report of one's own object", "goals" in c3rt("report", run / "own" / "run.mcap"))

    # a crash leaves the beginning
    cut = run / "cut.mcap"
    cut.write_bytes(file.read_bytes()[:file.stat().st_size // 2])
    words = c3rt("export", cut, "--out", run / "cut")
    check("what is left of a cut recording is read", "robot/state" in words)
print(f"{len(messages)} messages")
