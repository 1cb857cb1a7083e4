#pragma once
// What may come in: one check for every type of the wire, used by every reader. Whatever passes can
// be used without looking again: counts fit their arrays, enumerators are known, numbers are finite
// and of this world, texts end.
#include <cstdint>
#include <string>

#include "idl/topics.hpp"

namespace c3rt::wire {

/// Why a sample is not let in.
enum class Reason {
  kNone,
  kValue,         // a field is outside what it can mean
  kHeader,        // the sequence number or the time is
  kSecondWriter,  // its topic has one writer, and that is another one
  kOtherSession,  // it is not of the plant's session
  kOldSequence,   // its writer has sent this number or a later one before
};
constexpr int kReasonCount = 6;
const char* reason_name(Reason reason);  // "value", "header", "second writer", ...

/// A finding, without heap: texts are literals.
struct Refusal {
  enum class Expected { kRange, kUnitNorm, kText, kEnumerator, kFinite };
  Reason reason = Reason::kNone;
  const char* field = "";
  int index = -1;  // in an array
  Expected expected = Expected::kRange;
  double came = 0.0, low = 0.0, high = 0.0;

  explicit operator bool() const noexcept { return reason != Reason::kNone; }
};

/// "knot_count is 1000000, expected 1 to 16", "zero quaternion q_WB: norm 0, expected 1". Empty for
/// no refusal.
std::string to_text(const Refusal& refusal);

/// No stamp lies further ahead of the sample that carries it, and no sample further ahead of its
/// reader's clock.
constexpr std::int64_t kAhead_ns = 1'000'000'000;

/// Rules of the header that hold for every sample: the sequence begins at 1.
/// @param latest_ns no time may be later; topics with one writer carry no time before 0
/// RT: no heap, no lock, no throw.
Refusal validate(const Header& header, bool one_writer, std::int64_t latest_ns) noexcept;

/// Of every topic's type: each number that is used is finite, enumerators and truth values exist,
/// texts end; and what the type's own ranges in validate.cpp say. The ranges are wide: they keep
/// out what cannot be, not what a controller would rather not have. RT: no heap, no lock, no throw.
#define C3RT_TOPIC(Type, ...) Refusal validate(const Type& sample) noexcept;
C3RT_TOPICS(C3RT_TOPIC)
#undef C3RT_TOPIC

}  // namespace c3rt::wire
