#pragma once
// How many random instances a property test tries: few in the test suite, many with
// tests/properties.sh.
#include <cstdlib>

namespace c3rt::test {

/// C3RT_PROPERTY_INSTANCES, or 200. Instance i is made from seed i alone, so that a failure is
/// repeated by its number.
inline int property_instances() {
  const char* wanted = std::getenv("C3RT_PROPERTY_INSTANCES");
  const int instances = wanted != nullptr ? std::atoi(wanted) : 0;
  return instances > 0 ? instances : 200;
}

}  // namespace c3rt::test
