#pragma once
// A stranger's writer.
#include <cstdint>

#include <catch2/catch.hpp>
#include <dds/dds.h>

#include "idl/dds.hpp"

namespace c3rt::wire::test {

/// A writer that fills in nothing: session and sequence are the test's. What a client is, unless it
/// is told to be as strong as a process.
class RawWriter {
 public:
  RawWriter(const Bus& bus, const Topic& topic, std::int32_t strength = 0) {
    const dds_entity_t handle =
        dds_create_topic(bus.participant(), topic.descriptor, topic.name, nullptr, nullptr);
    dds_qos_t* qos = dds_create_qos();
    dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
    dds_qset_history(qos, DDS_HISTORY_KEEP_ALL, 0);
    dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
    dds_qset_liveliness(qos, DDS_LIVELINESS_AUTOMATIC, DDS_SECS(5));
    dds_qset_deadline(qos, DDS_MSECS(1));
    dds_qset_ownership_strength(qos, strength);
    writer_ = dds_create_writer(bus.participant(), handle, qos, nullptr);
    dds_delete_qos(qos);
  }
  template <typename T>
  void write(T sample, std::uint64_t session, std::uint64_t seq, std::int64_t time_ns = 1) {
    sample.header = {session, seq, time_ns};
    REQUIRE(dds_write(writer_, &sample) == DDS_RETCODE_OK);
  }
  bool matched() const {
    dds_publication_matched_status_t status{};
    dds_get_publication_matched_status(writer_, &status);
    return status.current_count > 0;
  }

 private:
  dds_entity_t writer_;
};

}  // namespace c3rt::wire::test
