"""A client in Python that knows docs/clients.md and the types of c3rt.idl: it reads one sample of every topic and writes
each of them back, until it is ended. Run by idl/python_client.

    python_client.py PAGE TYPES DOMAIN        CYCLONEDDS_URI names the DDS profile
"""
import importlib
import re
import sys
import time

page, types, domain = sys.argv[1:]
sys.path.insert(0, types)

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter, Publisher
from cyclonedds.sub import DataReader, Subscriber
from cyclonedds.topic import Topic
from cyclonedds.util import duration


def qos_of(words):
    """Of a cell of the table: "reliable, transient local, keep last 16, liveliness lease 1000 ms"."""
    policies = []
    for word in words.split(", "):
        number = int(re.search(r"\d+", word).group()) if re.search(r"\d", word) else 0
        if word == "reliable":
            policies.append(Policy.Reliability.Reliable(duration(seconds=1)))
        elif word == "best effort":
            policies.append(Policy.Reliability.BestEffort)
        elif word == "volatile":
            policies.append(Policy.Durability.Volatile)
        elif word == "transient local":
            policies.append(Policy.Durability.TransientLocal)
        elif word.startswith("keep last"):
            policies.append(Policy.History.KeepLast(number))
        elif word.startswith("deadline"):
            policies.append(Policy.Deadline(duration(milliseconds=number)))
        elif word.startswith("liveliness lease"):
            policies.append(Policy.Liveliness.Automatic(lease_duration=duration(milliseconds=number)))
        elif word.startswith("strength"):
            policies.append(Policy.OwnershipStrength(number))
        else:
            sys.exit(f"python_client.py: unknown words in the table: {word}")
    return policies


def partitions(name):
    """sim/tick has one for each process."""
    return Qos(Policy.Partition(["plant", "impedance", "planner", "vision", "recorder"])) if name == "sim/tick" else None


rows = re.findall(r"^\| ([a-z]+(?:/[a-z]+)?) \| (c3rt::\w+)::(\w+) \| ([^|]+) \| ([^|]+) \|$", open(page).read(), re.M)
participant = DomainParticipant(int(domain))
topics, readers, samples = {}, {}, {}
for name, module, kind, offered, requested in rows:
    kind = getattr(importlib.import_module(module.replace("::", ".")), kind)
    topics[name] = Topic(participant, name, kind), offered
    subscriber = Subscriber(participant, partitions(name))
    readers[name] = DataReader(subscriber, topics[name][0], Qos(*qos_of(requested)))

end = time.monotonic() + 60
while len(samples) < len(rows):
    if time.monotonic() > end:
        sys.exit(f"python_client.py: nothing was read of {', '.join(set(readers) - set(samples))}")
    for name, reader in readers.items():
        for sample in reader.take(10):
            if not hasattr(sample, "sample_info") or sample.sample_info.valid_data:
                samples[name] = sample
    time.sleep(0.02)
del readers
print(f"read {len(samples)}: {' '.join(sorted(samples))}", flush=True)

writers = {}
for name, (topic, offered) in topics.items():
    writers[name] = DataWriter(Publisher(participant, partitions(name)), topic, Qos(*qos_of(offered)))
while True:
    for name, writer in writers.items():
        samples[name].header.seq += 1
        writer.write(samples[name])
    time.sleep(0.02)
