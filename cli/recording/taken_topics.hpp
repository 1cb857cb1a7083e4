#pragma once
// Every topic that is recorded, off a bus.
#include <memory>
#include <tuple>

#include "cli/recording/listener.hpp"
#include "cli/recording/recording.hpp"
#include "cli/recording/samples.hpp"
#include "idl/dds.hpp"

namespace c3rt::cli {

/// A second of the fastest topic may wait until it is taken.
constexpr int kTakenDepth = 1024;

/// What becomes of what is taken.
struct Takers {
  Samples* samples;      // nullptr: nothing is kept
  Recording* recording;  // or none
  Listener* listener;    // or none
};

/// A topic on its way from the bus.
template <typename T>
struct Taken {
  explicit Taken(wire::Bus& bus) : reader(bus, kTakenDepth) {}
  void drain(const Takers& takers) {
    while (reader.take(newest)) {
      any = true;
      if (takers.listener != nullptr) takers.listener->hear(newest);
      if (takers.samples != nullptr) takers.samples->add(newest);
      if (takers.recording != nullptr) takers.recording->add(newest);
    }
  }
  wire::Reader<T> reader;
  T newest{};
  bool any = false;
};

template <typename Types>
struct TakenTopics;
/// Every topic that is recorded.
template <typename... T>
struct TakenTopics<std::tuple<T...>> {
  explicit TakenTopics(wire::Bus& bus) { ((make<T>(bus)), ...); }
  template <typename Action>
  void for_each(Action&& action) {
    std::apply([&action](auto&... topic) { ((topic != nullptr ? action(*topic) : void()), ...); },
               all_);
  }
  template <typename U>
  Taken<U>& of() {
    return *std::get<std::unique_ptr<Taken<U>>>(all_);
  }

 private:
  template <typename U>
  void make(wire::Bus& bus) {
    if (is_recorded(wire::topic<U>()))
      std::get<std::unique_ptr<Taken<U>>>(all_) = std::make_unique<Taken<U>>(bus);
  }
  std::tuple<std::unique_ptr<Taken<T>>...> all_;
};

}  // namespace c3rt::cli
