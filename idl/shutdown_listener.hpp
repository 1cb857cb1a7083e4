#pragma once
// Obeys and answers REQUEST_SHUTDOWN, so that no process has to.
#include <atomic>
#include <thread>

#include "idl/dds.hpp"

namespace c3rt::wire {

class ShutdownListener {
 public:
  ShutdownListener(Bus& bus, Process process);
  ~ShutdownListener();

 private:
  void run();

  Bus& bus_;
  Process process_;
  std::atomic<bool> stop_{false};
  Reader<ServiceRequest> requests_;
  Writer<ServiceReply> replies_;
  std::thread thread_;
};

}  // namespace c3rt::wire
