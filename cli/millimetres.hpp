#pragma once
// Lengths as a person reads them.
#include <cmath>

namespace c3rt::cli {

constexpr double kMillimetre = 1e-3;  // [m]

/// To a thousandth of a millimetre, so that what is zero but for rounding reads as 0.
inline double millimetres(double metres) { return std::round(metres * 1e6) * 1e-3 + 0.0; }

}  // namespace c3rt::cli
