#pragma once
// What `c3rt doctor` sees of the machine and of one DDS domain, before anything is judged.
#include <cstdint>
#include <string>
#include <vector>

#include "cli/client.hpp"

namespace c3rt::cli::doctor {

/// One of the four processes.
struct ProcessFacts {
  std::string name;  // "plant"
  bool in_service = false, heard = false;
  int pid = 0;
  std::string user, host;  // "" where not known
  std::uint64_t session = 0;
  std::string state, text;           // of service/status
  std::vector<std::string> refused;  // a sentence for each kind of refused samples
  std::string program;               // the file that it runs; "" where this user may not see it
  bool replaced = false;             // that file is another one now, or gone
  bool installed = true;             // there is a program of that name to start
};

/// A limit of the kernel, -1: none.
constexpr long long kUnlimited = -1;

/// What the scheduler grants.
struct SchedulingFacts {
  int wanted_priority = 0;            // of the highest servo thread
  std::string refused;                // why SCHED_FIFO at that priority is refused; "": granted
  long long priority_limit = 0;       // RLIMIT_RTPRIO
  long long locked_memory_bytes = 0;  // RLIMIT_MEMLOCK
  bool may_lock_any = false;          // CAP_IPC_LOCK
  long long real_time_share_us = -1;  // of a second that real-time threads may take; -1: all
  bool real_time_kernel = false;      // PREEMPT_RT
  std::string kernel;                 // its release
};

struct MachineFacts {
  int cores = 0;  // that this process may use
  std::string clock_source;
  std::vector<std::string> governors;  // each once; empty: the machine tells none
};

/// A network interface that a DDS profile names.
struct InterfaceFacts {
  std::string name;
  bool exists = false, up = false;
};

struct ProfileFacts {
  std::string name, path;
  std::string refused;  // why it cannot be used; "": a participant joined the domain
  std::vector<InterfaceFacts> interfaces;
  bool any_interface = false;          // it leaves the choice to DDS
  std::vector<std::string> available;  // interfaces of this host that are up
};

/// What is wrong with a key, and what to do about it.
struct KeyProblem {
  std::string text, advice;
};

/// Of a secure profile.
struct KeyFacts {
  std::string folder;  // "": the profile needs no keys
  std::vector<KeyProblem> problems;
  std::string expires;  // the first of them does: "2027-11-29 12:00:00 UTC"
  int days_left = 0;
};

struct FolderFacts {
  std::string what, path;  // "runtime folder", "/run/user/1000/c3rt"
  std::string refused;     // why nothing can be written there; ""
  long long free_bytes = 0;
};

/// A program of others that some commands need.
struct ToolFacts {
  std::string program, package, needed_for;
  bool found = false;
};

struct Facts {
  std::string version;
  std::uint32_t domain = 0;
  std::string instance;  // that holds the domain: "c3rt up circle_slow (realtime, pid 12, …)"
  std::vector<std::string> notes;  // of its supervisor
  std::vector<ProcessFacts> processes;
  std::vector<std::string> strangers;      // other processes that write on the plant's loop
  std::vector<std::string> peer_problems;  // of all processes: QoS, types, partitions
  SchedulingFacts scheduling;
  MachineFacts machine;
  ProfileFacts profile;
  KeyFacts keys;
  std::vector<FolderFacts> folders;
  std::vector<ToolFacts> tools;
};

/// Looks; changes nothing but a probe file that it removes again. Takes about three seconds on the
/// bus.
Facts collect(const Seat& seat);

}  // namespace c3rt::cli::doctor
