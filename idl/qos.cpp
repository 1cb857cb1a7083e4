#include "idl/qos.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <string>

#include "idl/discovery.hpp"
#include "idl/one_writer.hpp"

namespace c3rt::wire {

namespace {

// a reliable write waits this long for slow readers before it fails
constexpr dds_duration_t kMaxBlockingRealtime = DDS_MSECS(10);
// longer than the lease of a participant (10 s): a suspended client holds up a run, and loses it
// nothing
constexpr dds_duration_t kMaxBlockingLockstep = DDS_SECS(30);
constexpr dds_duration_t kPlanLease = DDS_SECS(1);
constexpr dds_duration_t kStatusLease = DDS_SECS(1);
// longer than any stall of a loaded machine: in lockstep a lost peer ends the run
constexpr dds_duration_t kSyncLease = DDS_SECS(5);
constexpr int kEventDepth = 16;

QosPointer new_qos() {
  QosPointer qos(dds_create_qos());
  // a writer that ends leaves its last samples to the readers
  dds_qset_writer_data_lifecycle(qos.get(), false);
  return qos;
}

using Names = std::array<const char*, kProcessCount>;

Names all_processes() {
  Names names{};
  for (int i = 0; i < kProcessCount; ++i)
    names[static_cast<std::size_t>(i)] = process_name(static_cast<Process>(i));
  return names;
}

// a partition for each process
void set_addressee(dds_qos_t* qos, const Topic& topic, std::optional<Process> addressee) {
  if (topic.trait != Trait::kAddressed) return;
  Names names = all_processes();
  if (addressee) {
    dds_qset_partition1(qos, process_name(*addressee));
  } else {
    dds_qset_partition(qos, kProcessCount, names.data());
  }
}

std::set<std::string> addressees(const dds_qos_t* qos) {
  std::uint32_t count = 0;
  char** names = nullptr;
  std::set<std::string> result;
  if (!dds_qget_partition(qos, &count, &names)) return result;
  for (std::uint32_t i = 0; i < count; ++i) {
    result.insert(names[i]);
    dds_free(names[i]);
  }
  dds_free(names);
  return result;
}

void set_history(dds_qos_t* qos, int depth) { dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, depth); }

// late readers get up to `depth` samples of what was written before they came
void set_transient_local(dds_qos_t* qos, int depth) {
  dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
  dds_qset_durability_service(qos, 0, DDS_HISTORY_KEEP_LAST, depth, DDS_LENGTH_UNLIMITED,
                              DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
}

bool in_lockstep(const Topic& topic, ClockMode clock) {
  return topic.qos == Qos::kSync ||
         (clock == ClockMode::kLockstep &&
          (topic.qos == Qos::kStream || topic.qos == Qos::kReport || topic.qos == Qos::kPlan));
}

const char* name(dds_reliability_kind_t kind) {
  return kind == DDS_RELIABILITY_RELIABLE ? "RELIABLE" : "BEST_EFFORT";
}
const char* name(dds_ownership_kind_t kind) {
  return kind == DDS_OWNERSHIP_EXCLUSIVE ? "EXCLUSIVE ownership" : "SHARED ownership";
}
const char* name(dds_durability_kind_t kind) {
  switch (kind) {
    case DDS_DURABILITY_VOLATILE:
      return "VOLATILE";
    case DDS_DURABILITY_TRANSIENT_LOCAL:
      return "TRANSIENT_LOCAL";
    case DDS_DURABILITY_TRANSIENT:
      return "TRANSIENT";
    case DDS_DURABILITY_PERSISTENT:
      return "PERSISTENT";
  }
  return "unknown durability";
}
const char* name(dds_liveliness_kind_t kind) {
  switch (kind) {
    case DDS_LIVELINESS_AUTOMATIC:
      return "AUTOMATIC liveliness";
    case DDS_LIVELINESS_MANUAL_BY_PARTICIPANT:
      return "MANUAL_BY_PARTICIPANT liveliness";
    case DDS_LIVELINESS_MANUAL_BY_TOPIC:
      return "MANUAL_BY_TOPIC liveliness";
  }
  return "unknown liveliness";
}
std::string duration(const char* what, dds_duration_t value) {
  if (value == DDS_INFINITY) return std::string("no ") + what;
  return std::string(what) + " of " + std::to_string(value / DDS_MSECS(1)) + " ms";
}

}  // namespace

QosPointer writer_qos(const Topic& topic, ClockMode clock, std::optional<Process> addressee) {
  QosPointer qos = new_qos();
  set_addressee(qos.get(), topic, addressee);
  const dds_duration_t blocking =
      clock == ClockMode::kLockstep ? kMaxBlockingLockstep : kMaxBlockingRealtime;
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, blocking);
  switch (topic.qos) {
    case Qos::kStream:
    case Qos::kReport:
      set_history(qos.get(), 1);
      if (clock == ClockMode::kRealtime)
        dds_qset_reliability(qos.get(), DDS_RELIABILITY_BEST_EFFORT, 0);
      break;
    case Qos::kPlan:
      set_history(qos.get(), 1);
      dds_qset_liveliness(qos.get(), DDS_LIVELINESS_AUTOMATIC, kPlanLease);
      break;
    case Qos::kEvent:
      set_history(qos.get(), kEventDepth);
      set_transient_local(qos.get(), kEventDepth);
      break;
    case Qos::kStatus:
      set_history(qos.get(), 1);
      set_transient_local(qos.get(), 1);
      dds_qset_liveliness(qos.get(), DDS_LIVELINESS_AUTOMATIC, kStatusLease);
      break;
    case Qos::kSync:
      dds_qset_liveliness(qos.get(), DDS_LIVELINESS_AUTOMATIC, kSyncLease);
      break;
  }
  if (in_lockstep(topic, clock)) {
    set_history(qos.get(), kLockstepDepth);
    // a reader that is discovered after the first sample still gets it
    set_transient_local(qos.get(), kLockstepDepth);
  }
  if (topic.writer || topic.qos == Qos::kSync)
    dds_qset_ownership_strength(qos.get(), kProcessStrength);
  // offered in both clocks, so that a realtime client can listen to a lockstep run
  if (topic.deadline_s > 0.0)
    dds_qset_deadline(qos.get(), static_cast<dds_duration_t>(topic.deadline_s * 1e9));
  return qos;
}

QosPointer reader_qos(const Topic& topic, ClockMode clock, int depth,
                      std::optional<Process> addressee) {
  QosPointer qos = new_qos();
  set_addressee(qos.get(), topic, addressee);
  const bool lockstep = in_lockstep(topic, clock);
  const bool best_effort = (topic.qos == Qos::kStream || topic.qos == Qos::kReport) && !lockstep;
  dds_qset_reliability(qos.get(),
                       best_effort ? DDS_RELIABILITY_BEST_EFFORT : DDS_RELIABILITY_RELIABLE,
                       DDS_MSECS(100));
  set_history(qos.get(), lockstep && depth < kLockstepDepth ? kLockstepDepth : depth);
  if (lockstep || topic.qos == Qos::kEvent || topic.qos == Qos::kStatus) {
    dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
  }
  if (topic.deadline_s > 0.0 && clock == ClockMode::kRealtime) {
    dds_qset_deadline(qos.get(), static_cast<dds_duration_t>(topic.deadline_s * 1e9));
  }
  return qos;
}

std::string partitions(const dds_qos_t* qos) {
  std::string text;
  for (const std::string& name : addressees(qos)) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "no partition" : "the partition " + text;
}

std::string describe(const dds_qos_t* qos) {
  std::string text;
  const auto say = [&text](const std::string& what) { text += (text.empty() ? "" : ", ") + what; };
  const auto milliseconds = [](dds_duration_t value) {
    return std::to_string(value / DDS_MSECS(1)) + " ms";
  };
  dds_duration_t unused = 0;
  dds_reliability_kind_t reliability = DDS_RELIABILITY_BEST_EFFORT;
  if (dds_qget_reliability(qos, &reliability, &unused))
    say(reliability == DDS_RELIABILITY_RELIABLE ? "reliable" : "best effort");
  dds_durability_kind_t durability = DDS_DURABILITY_VOLATILE;
  dds_qget_durability(qos, &durability);
  say(durability == DDS_DURABILITY_VOLATILE          ? "volatile"
      : durability == DDS_DURABILITY_TRANSIENT_LOCAL ? "transient local"
                                                     : name(durability));
  dds_history_kind_t history = DDS_HISTORY_KEEP_LAST;
  std::int32_t depth = 0;
  if (dds_qget_history(qos, &history, &depth))
    say(history == DDS_HISTORY_KEEP_ALL ? "keep all" : "keep last " + std::to_string(depth));
  dds_duration_t deadline = DDS_INFINITY, lease = DDS_INFINITY;
  if (dds_qget_deadline(qos, &deadline) && deadline != DDS_INFINITY)
    say("deadline " + milliseconds(deadline));
  dds_liveliness_kind_t kind = DDS_LIVELINESS_AUTOMATIC;
  if (dds_qget_liveliness(qos, &kind, &lease) && lease != DDS_INFINITY)
    say("liveliness lease " + milliseconds(lease));
  std::int32_t strength = 0;
  if (dds_qget_ownership_strength(qos, &strength) && strength != 0)
    say("strength " + std::to_string(strength));
  return text;
}

std::string offered_qos(const Topic& topic) {
  return describe(writer_qos(topic, ClockMode::kRealtime, {}).get());
}
std::string requested_qos(const Topic& topic) {
  return describe(reader_qos(topic, ClockMode::kRealtime, 1, {}).get());
}

bool same_addressee(const dds_qos_t* one, const dds_qos_t* other) {
  const std::set<std::string> a = addressees(one), b = addressees(other);
  return (a.empty() && b.empty()) || std::any_of(a.begin(), a.end(), [&](const std::string& name) {
           return b.count(name) > 0;
         });
}

bool disagree(const dds_qos_t* offered, const dds_qos_t* requested, Disagreement& difference) {
  dds_duration_t unused = 0;
  dds_reliability_kind_t offered_reliability = DDS_RELIABILITY_BEST_EFFORT,
                         requested_reliability = offered_reliability;
  if (dds_qget_reliability(offered, &offered_reliability, &unused) &&
      dds_qget_reliability(requested, &requested_reliability, &unused) &&
      offered_reliability < requested_reliability) {
    difference = {name(offered_reliability), name(requested_reliability)};
    return true;
  }
  dds_ownership_kind_t offered_ownership = DDS_OWNERSHIP_SHARED,
                       requested_ownership = offered_ownership;
  if (dds_qget_ownership(offered, &offered_ownership) &&
      dds_qget_ownership(requested, &requested_ownership) &&
      offered_ownership != requested_ownership) {
    difference = {name(offered_ownership), name(requested_ownership)};
    return true;
  }
  dds_durability_kind_t offered_durability = DDS_DURABILITY_VOLATILE,
                        requested_durability = offered_durability;
  if (dds_qget_durability(offered, &offered_durability) &&
      dds_qget_durability(requested, &requested_durability) &&
      offered_durability < requested_durability) {
    difference = {name(offered_durability), name(requested_durability)};
    return true;
  }
  dds_duration_t offered_deadline = DDS_INFINITY, requested_deadline = DDS_INFINITY;
  if (dds_qget_deadline(offered, &offered_deadline) &&
      dds_qget_deadline(requested, &requested_deadline) && offered_deadline > requested_deadline) {
    difference = {duration("deadline", offered_deadline), duration("deadline", requested_deadline)};
    return true;
  }
  dds_liveliness_kind_t offered_kind = DDS_LIVELINESS_AUTOMATIC, requested_kind = offered_kind;
  dds_duration_t offered_lease = DDS_INFINITY, requested_lease = DDS_INFINITY;
  if (dds_qget_liveliness(offered, &offered_kind, &offered_lease) &&
      dds_qget_liveliness(requested, &requested_kind, &requested_lease)) {
    if (offered_kind < requested_kind) {
      difference = {name(offered_kind), name(requested_kind)};
      return true;
    }
    if (offered_lease > requested_lease) {
      difference = {duration("liveliness lease", offered_lease),
                    duration("liveliness lease", requested_lease)};
      return true;
    }
  }
  return false;
}

}  // namespace c3rt::wire
