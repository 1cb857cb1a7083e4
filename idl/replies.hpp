#pragma once
// A process's answers to clients' requests, targets and faults.
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>

#include "idl/dds.hpp"

namespace c3rt::wire {

class Replies {
 public:
  Replies(Bus& bus, Process process) : process_(process), writer_(bus) {}

  /// @param request_id of what is answered; 0: no reply is wanted
  void answer(std::uint64_t request_id, bool ok, const std::string& text, std::int64_t now_ns) {
    if (request_id == 0) return;
    ServiceReply reply{};
    reply.request_id = request_id;
    reply.process = process_;
    reply.ok = ok;
    std::snprintf(reply.text, sizeof reply.text, "%s", text.c_str());
    writer_.write(reply, now_ns);
  }
  /// Answers what a reader refused and this process was asked for.
  template <typename T>
  void answer_refused(Reader<T>& reader, std::int64_t now_ns) {
    T sample{};
    Refusal why;
    while (reader.take_refused(sample, why)) {
      if (is_for(process_, sample))
        answer(sample.request_id, false, "refused: " + to_text(why), now_ns);
    }
  }

 private:
  /// Of a sample that was not let in.
  template <typename T>
  static bool is_for(Process process, const T& sample) {
    if constexpr (kNamesProcess<T>) {
      // it may be no enumerator
      return std::memcmp(&sample.process, &process, sizeof process) == 0;
    }
    return true;  // nobody else reads it
  }

  Process process_;
  Writer<ServiceReply> writer_;
};

}  // namespace c3rt::wire
