#include "idl/raw_ping.hpp"

#include <atomic>
#include <string>

#include <dds/dds.h>

#include "controller/rt/periodic_clock.hpp"
#include "idl/process.hpp"
#include "idl/qos.hpp"

namespace c3rt::wire {
namespace {

constexpr const char* kThere = "latency/there";
constexpr const char* kBack = "latency/back";

Entity created(dds_entity_t handle, const std::string& what) {
  if (handle < 0) throw WireError("cannot create " + what + ": " + dds_strretcode(handle));
  return Entity(handle);
}

QosPointer plain_qos() {
  QosPointer qos(dds_create_qos());
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_BEST_EFFORT, 0);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 1);
  return qos;
}

/// A writer of one topic and a reader of the other, whose listener gets `context`.
struct Ends {
  Ends(Bus& bus, bool echo, dds_on_data_available_fn arrived, void* context) {
    const char* out = echo ? kBack : kThere;
    const char* in = echo ? kThere : kBack;
    const QosPointer qos = plain_qos();
    out_topic =
        created(dds_create_topic(bus.participant(), descriptor(echo), out, nullptr, nullptr), out);
    in_topic =
        created(dds_create_topic(bus.participant(), descriptor(!echo), in, nullptr, nullptr), in);
    writer = created(dds_create_writer(bus.participant(), out_topic.handle(), qos.get(), nullptr),
                     std::string("the writer of ") + out);
    dds_listener_t* listener = dds_create_listener(context);
    dds_lset_data_available(listener, arrived);
    reader = Entity(dds_create_reader(bus.participant(), in_topic.handle(), qos.get(), listener));
    dds_delete_listener(listener);
    if (reader.handle() < 0) throw WireError(std::string("cannot create the reader of ") + in);
  }
  static const dds_topic_descriptor_t* descriptor(bool of_command) {
    return of_command ? topic<RobotCommand>().descriptor : topic<RobotState>().descriptor;
  }
  // the reader goes first: its listener may be running until then
  Entity out_topic, in_topic, writer, reader;
};

/// The newest sample, or false.
template <typename T>
bool take(dds_entity_t reader, T& sample) noexcept {
  void* slot = &sample;
  dds_sample_info_t info{};
  return dds_take(reader, &slot, &info, 1, 1) == 1 && info.valid_data;
}

}  // namespace

struct RawEcho::Implementation {
  explicit Implementation(Bus& bus) : ends(bus, true, &Implementation::answer, this) {}
  static void answer(dds_entity_t reader, void* self) {
    auto& echo = *static_cast<Implementation*>(self);
    if (!take(reader, echo.state)) return;
    echo.command.header = echo.state.header;
    // the constructor may still be about to store it
    if (const dds_entity_t writer = echo.ends.writer.handle(); writer > 0)
      dds_write(writer, &echo.command);
  }
  RobotState state{};
  RobotCommand command{};
  Ends ends;
};

RawEcho::RawEcho(Bus& bus) : implementation_(std::make_unique<Implementation>(bus)) {}
RawEcho::~RawEcho() = default;

struct RawPing::Implementation {
  explicit Implementation(Bus& bus) : ends(bus, false, &Implementation::arrived, this) {}
  static void arrived(dds_entity_t reader, void* self) {
    auto& ping = *static_cast<Implementation*>(self);
    const std::int64_t at_ns = rt::now_ns();
    if (!take(reader, ping.command)) return;
    if (ping.command.header.seq != ping.wanted.load()) return;  // too late
    ping.arrived_ns.store(at_ns);
    ping.arrival.raise();
  }
  RobotState state{};
  RobotCommand command{};
  std::atomic<std::uint64_t> wanted{0};
  std::atomic<std::int64_t> arrived_ns{0};
  Signal arrival;
  Ends ends;
};

RawPing::RawPing(Bus& bus) : implementation_(std::make_unique<Implementation>(bus)) {}
RawPing::~RawPing() = default;

std::int64_t RawPing::round_trip_ns(std::int64_t timeout_ns) noexcept {
  Implementation& ping = *implementation_;
  ping.arrived_ns.store(0);
  ping.state.header.seq = ping.wanted.load() + 1;
  ping.wanted.store(ping.state.header.seq);
  const std::int64_t sent_ns = rt::now_ns();
  if (dds_write(ping.ends.writer.handle(), &ping.state) != DDS_RETCODE_OK) return -1;
  while (rt::now_ns() - sent_ns < timeout_ns) {
    ping.arrival.wait(timeout_ns);
    if (const std::int64_t at_ns = ping.arrived_ns.load(); at_ns != 0) return at_ns - sent_ns;
  }
  return -1;
}

}  // namespace c3rt::wire
