#pragma once
// Quality of service of every topic: the numbers behind wire::Qos, and what two endpoints disagree
// on.
#include <memory>
#include <optional>
#include <string>

#include <dds/dds.h>

#include "idl/dds.hpp"

namespace c3rt::wire {

struct QosDeleter {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using QosPointer = std::unique_ptr<dds_qos_t, QosDeleter>;

/// Samples that a reader or writer keeps in lockstep, where none may be lost.
constexpr int kLockstepDepth = 256;

/// @param addressee of an addressed topic; nothing: all
QosPointer writer_qos(const Topic& topic, ClockMode clock, std::optional<Process> addressee);
QosPointer reader_qos(const Topic& topic, ClockMode clock, int depth,
                      std::optional<Process> addressee);

/// Why a writer that offers one cannot serve a reader that requests the other; empty if it can.
/// "requests RELIABLE", "offers BEST_EFFORT" come as the two halves of a sentence.
struct Disagreement {
  std::string offered;
  std::string requested;
};
bool disagree(const dds_qos_t* offered, const dds_qos_t* requested, Disagreement& difference);

/// "the partition left" or "no partition".
std::string partitions(const dds_qos_t* qos);

/// False where the samples of one are addressed to other processes than the other's.
bool same_addressee(const dds_qos_t* one, const dds_qos_t* other);

/// "reliable, transient local, keep last 16, liveliness lease 1000 ms"
std::string describe(const dds_qos_t* qos);

}  // namespace c3rt::wire
