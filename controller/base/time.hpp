#pragma once
// Times are nanoseconds on the wire and seconds in formulas.
#include <cmath>
#include <cstdint>

namespace c3rt::base {

/// RT: no heap, no lock, no throw.
inline double seconds(std::int64_t time_ns) noexcept { return 1e-9 * static_cast<double>(time_ns); }

/// The nearest one. What is not finite or beyond 290 years has none: the edge refuses it before.
/// RT: no heap, no lock, no throw.
inline std::int64_t nanoseconds(double time_s) noexcept { return std::llround(1e9 * time_s); }

}  // namespace c3rt::base
