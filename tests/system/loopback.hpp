#pragma once
// The bus of a test: a domain of its own, as tests run beside each other.
#include <cstdint>

#include "idl/dds.hpp"
#include "tests/support/own_domain.hpp"

namespace c3rt::test {

inline std::uint32_t test_domain() { return support::kOwnDomain; }

inline wire::BusSettings loopback_settings() {
  wire::BusSettings bus;
  bus.domain = test_domain();
  bus.profile_uri = C3RT_SOURCE_DIRECTORY "/config/dds/loopback.xml";
  return bus;
}

}  // namespace c3rt::test
