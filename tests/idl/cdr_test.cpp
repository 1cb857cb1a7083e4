#include "idl/cdr.hpp"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <string>

#include <catch2/catch.hpp>
#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>

#include "idl/dds.hpp"
#include "tests/idl/samples.hpp"
#include "tests/support/own_domain.hpp"

using namespace c3rt;
using namespace c3rt::wire;

namespace {

template <typename T>
Bytes cdr_of(const T& sample) {
  Bytes bytes;
  to_cdr(sample, bytes);
  return bytes;
}

/// What Cyclone sends for a sample.
template <typename T>
Bytes sent_by_cyclone(const Bus& bus, const T& sample) {
  const std::string name = std::string("cdr/") + topic<T>().name;
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  const dds_entity_t entity =
      dds_create_topic(bus.participant(), topic<T>().descriptor, name.c_str(), qos, nullptr);
  REQUIRE(entity > 0);
  const dds_entity_t reader = dds_create_reader(bus.participant(), entity, qos, nullptr);
  const dds_entity_t writer = dds_create_writer(bus.participant(), entity, qos, nullptr);
  dds_delete_qos(qos);
  REQUIRE(dds_write(writer, &sample) == DDS_RETCODE_OK);
  ddsi_serdata* data = nullptr;
  dds_sample_info_t info;
  REQUIRE(dds_takecdr(reader, &data, 1, &info, DDS_ANY_STATE) == 1);
  Bytes bytes(ddsi_serdata_size(data));
  ddsi_serdata_to_ser(data, 0, bytes.size(), bytes.data());
  ddsi_serdata_unref(data);
  return bytes;
}

TEST_CASE("CDR: the bytes of every topic are those that Cyclone sends") {
  BusSettings settings;
  settings.domain = support::kOwnDomain;
  settings.profile_uri = C3RT_SOURCE_DIRECTORY "/config/dds/loopback.xml";
  settings.session_id = 7;
  const Bus bus(settings);
  for_each_topic([&](const auto& kind) {
    using T = std::decay_t<decltype(kind)>;
    CAPTURE(topic<T>().name);
    for (const T& sample : {wire::test::numbered<T>(), wire::test::plain<T>()}) {
      const Bytes sent = sent_by_cyclone(bus, sample), ours = cdr_of(sample);
      REQUIRE(ours.size() == sent.size());
      CHECK(std::memcmp(ours.data(), sent.data(), cdr::kEncapsulation - 1) == 0);
      CHECK(std::memcmp(ours.data() + cdr::kEncapsulation, sent.data() + cdr::kEncapsulation,
                        sent.size() - cdr::kEncapsulation) == 0);
    }
  });
}

TEST_CASE("CDR: what was written is read again, to the last bit") {
  for_each_topic([&](const auto& kind) {
    using T = std::decay_t<decltype(kind)>;
    CAPTURE(topic<T>().name);
    const Bytes bytes = cdr_of(wire::test::numbered<T>());
    T read;
    REQUIRE(from_cdr(bytes.data(), bytes.size(), read));
    CHECK(cdr_of(read) == bytes);
  });
}

TEST_CASE(
    "CDR: bytes that are cut off, of another representation, or of no text or truth are refused") {
  for_each_topic([&](const auto& kind) {
    using T = std::decay_t<decltype(kind)>;
    CAPTURE(topic<T>().name);
    const Bytes bytes = cdr_of(wire::test::numbered<T>());
    T read;
    for (std::size_t size = 0; size + cdr::kEnd <= bytes.size(); size += 1 + size / 16)
      REQUIRE_FALSE(from_cdr(bytes.data(), size, read));
    Bytes other = bytes;
    other[1] = 0;  // big endian
    CHECK_FALSE(from_cdr(other.data(), other.size(), read));
  });
  auto scene = wire::test::plain<Scene>();
  scene.exposure = true;
  Bytes bytes = cdr_of(scene);
  // the first byte that differs where it is false
  scene.exposure = false;
  const Bytes dark = cdr_of(scene);
  std::size_t at = 0;
  while (bytes[at] == dark[at]) ++at;
  bytes[at] = 2;
  Scene read;
  CHECK_FALSE(from_cdr(bytes.data(), bytes.size(), read));

  auto reply = wire::test::plain<ServiceReply>();
  set_text(reply.text, "abc");
  Bytes text = cdr_of(reply);
  const auto word = std::search(text.begin(), text.end(), std::begin("abc"), std::end("abc"));
  REQUIRE(word != text.end());
  *(word + 3) = 'd';  // its end
  ServiceReply answer;
  CHECK_FALSE(from_cdr(text.data(), text.size(), answer));
}

}  // namespace
