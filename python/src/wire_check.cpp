// What c3rt.client lets in: on the bytes of a sample, the rules that every reader of the processes
// keeps.
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>

#include <nanobind/nanobind.h>
#include <nanobind/stl/string_view.h>

#include "idl/cdr.hpp"
#include "idl/validate.hpp"
#include "python/src/arrays.hpp"
#include "python/src/bind.hpp"

namespace c3rt::python {
namespace {

using namespace nb::literals;

template <typename T>
std::string refusal_of(const std::uint8_t* data, std::size_t size) {
  T sample;
  if (!wire::from_cdr(data, size, sample))
    return std::string("not the bytes of a sample of ") + wire::topic<T>().name;
  // how far ahead a time may be is known where the plant's clock is; a client can be on another
  // host
  constexpr std::int64_t kAnyTime = std::numeric_limits<std::int64_t>::max();
  const wire::Refusal of_header =
      wire::validate(sample.header, wire::topic<T>().writer.has_value(), kAnyTime);
  return wire::to_text(of_header ? of_header : wire::validate(sample));
}

std::string refusal(std::string_view topic, const nb::bytes& data) {
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(data.c_str());
#define C3RT_TOPIC(Type, ...) \
  if (topic == wire::topic<wire::Type>().name) return refusal_of<wire::Type>(bytes, data.size());
  C3RT_TOPICS(C3RT_TOPIC)
#undef C3RT_TOPIC
  throw std::invalid_argument("topic: expected one of idl/topics.hpp, got " + std::string(topic));
}

}  // namespace

void bind_wire_check(nb::module_& module) {
  module.def("refusal", &refusal, "topic"_a, "data"_a,
             "Why a sample of a topic, as it crosses the network, is not let in; empty: it is.");
}

}  // namespace c3rt::python
