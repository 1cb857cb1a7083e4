#pragma once
// Field by field: in what two samples of one topic differ.
#include <string>
#include <vector>

#include "idl/topics.hpp"

namespace c3rt::cli::replay {

struct Difference {
  std::string field;            // "knots[0].p_WE_m[2]"
  std::string recorded, given;  // as a person reads them; "" where a list is shorter
  double amount = 0.0;          // |recorded - given|; 0 of what is no number
};

/// Without what is another one in each run: session and numbers, times that the machine measured.
/// Numbers differ where their bits do.
template <typename T>
std::vector<Difference> differences(const T& recorded, const T& given);

#define C3RT_TOPIC(Type, ...) \
  extern template std::vector<Difference> differences(const wire::Type&, const wire::Type&);
C3RT_TOPICS(C3RT_TOPIC)
#undef C3RT_TOPIC

/// Without the places in lists: "knots.p_WE_m"
std::string without_places(const std::string& field);

}  // namespace c3rt::cli::replay
