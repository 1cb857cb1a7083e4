#include "idl/dds.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <mutex>
#include <sstream>

#include <dds/dds.h>
#include <dds/ddsrt/log.h>
#include <pthread.h>
#include <sched.h>

#include "controller/rt/periodic_clock.hpp"
#include "idl/exchange.hpp"
#include "idl/one_writer.hpp"
#include "idl/peers.hpp"
#include "idl/qos.hpp"
#include "idl/security.hpp"

namespace c3rt::wire {

namespace {

constexpr std::uint64_t kNoLimit = ~std::uint64_t{0};
// a writer of a periodic topic that misses so many of its deadlines in a row is gone
constexpr double kMissedDeadlines = 5.0;
constexpr double kSilence_s = 0.5;                    // of a topic without a deadline
constexpr std::int64_t kHistory_ns = 10'000'000'000;  // both ends have found each other by then
constexpr int kRobotState = topic<RobotState>().stream;

Entity created(dds_entity_t handle, const std::string& what) {
  if (handle < 0) throw WireError("cannot create " + what + ": " + dds_strretcode(handle));
  return Entity(handle);
}

constexpr std::uintmax_t kLargestProfile = 1 << 20;  // bytes

/// What Cyclone has to say while it reads a configuration, kept instead of printed.
class Complaints {
 public:
  Complaints() { dds_set_log_sink(&keep, &texts_); }
  ~Complaints() { dds_set_log_sink(nullptr, nullptr); }
  Complaints(const Complaints&) = delete;
  Complaints& operator=(const Complaints&) = delete;

  std::string first() const { return texts_.empty() ? "" : texts_.front(); }

 private:
  static void keep(void* texts, const dds_log_data_t* data) {
    std::string text(data->message, data->size);
    while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
    static_cast<std::vector<std::string>*>(texts)->push_back(text);
  }
  std::vector<std::string> texts_;
};

std::string text_of(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

struct Profile {
  std::string name, text;
  std::string uri;  // what Cyclone takes for it
};

/// @param profile a file or, as it begins with <, its text
Profile read_profile(const std::string& profile) {
  if (profile.rfind('<', 0) == 0) return {"DDS profile", profile, profile};
  const std::string name = "DDS profile " + profile;
  std::error_code error;
  const auto path = std::filesystem::canonical(profile, error);
  if (error) throw ProfileError(name + ": " + error.message());
  const auto size = std::filesystem::file_size(path, error);
  if (error || size == 0 || size > kLargestProfile) {
    throw ProfileError(name + ": expected a file of 1 to " + std::to_string(kLargestProfile) +
                       " bytes, got " + (error ? error.message() : std::to_string(size)));
  }
  return {name, text_of(path), "file://" + path.string()};
}

/// Cyclone's state of one domain in this process, configured by a file and shared by every Bus on
/// it.
class Domain {
 public:
  Domain(std::uint32_t id, const std::string& profile, const std::string& identity)
      : id_(id), configured_(!profile.empty()) {
    if (!configured_) return;
    const std::lock_guard lock(mutex());
    Shared& shared = domains()[id_];
    if (shared.users == 0) {
      const Profile chosen = read_profile(profile);
      shared.secure = is_secure(chosen.text);
      const std::string configuration =
          shared.secure ? with_keys(chosen.text, keys_directory(), identity) : chosen.uri;
      const Complaints complaints;
      shared.handle = dds_create_domain(id_, configuration.c_str());
      // somebody else in this process may already use the domain, with a configuration of its own
      if (shared.handle < 0 && shared.handle != DDS_RETCODE_PRECONDITION_NOT_MET) {
        std::string reason = complaints.first();
        if (reason.empty()) reason = dds_strretcode(shared.handle);
        domains().erase(id_);
        if (reason.find("participant index") != std::string::npos) {
          reason =
              "as many programs use the domain as the profile allows (MaxAutoParticipantIndex; "
              "119 with the profile loopback): end some, or use another domain";
        }
        throw ProfileError(chosen.name + ", domain " + std::to_string(id_) + ": " + reason);
      }
    }
    // Cyclone has one configuration for a domain in a process
    if (shared.users == 0) shared.identity = identity;
    if (shared.secure && shared.identity != identity) {
      throw WireError("domain " + std::to_string(id_) +
                      ": this process joined it with the keys of " + shared.identity +
                      ", and cannot join it with those of " + identity + " too");
    }
    ++shared.users;
  }
  ~Domain() {
    if (!configured_) return;
    const std::lock_guard lock(mutex());
    Shared& shared = domains()[id_];
    if (--shared.users > 0) return;
    if (shared.handle > 0) dds_delete(shared.handle);
    domains().erase(id_);
  }
  bool secure() const {
    const std::lock_guard lock(mutex());
    return configured_ && domains()[id_].secure;
  }
  Domain(const Domain&) = delete;
  Domain& operator=(const Domain&) = delete;

 private:
  struct Shared {
    dds_entity_t handle = 0;
    bool secure = false;
    std::string identity;
    int users = 0;
  };
  static std::mutex& mutex() {
    static std::mutex instance;
    return instance;
  }
  static std::map<std::uint32_t, Shared>& domains() {
    static std::map<std::uint32_t, Shared> instance;
    return instance;
  }

  std::uint32_t id_;
  bool configured_;
};

/// Blocks one thread until an attached condition triggers or somebody interrupts.
class Waiter {
 public:
  Waiter(dds_entity_t participant, const std::string& owner)
      : waitset_(created(dds_create_waitset(participant), "the wait set of " + owner)),
        guard_(created(dds_create_guardcondition(participant), "the guard condition of " + owner)) {
    attach(guard_);
  }
  void attach(const Entity& condition) {
    dds_waitset_attach(waitset_.handle(), condition.handle(), 0);
  }
  void detach(const Entity& condition) {
    dds_waitset_detach(waitset_.handle(), condition.handle());
  }
  void wait(std::int64_t timeout_ns) noexcept {
    dds_waitset_wait(waitset_.handle(), nullptr, 0, std::max<std::int64_t>(timeout_ns, 0));
    bool triggered = false;
    dds_take_guardcondition(guard_.handle(), &triggered);
  }
  void interrupt() noexcept { dds_set_guardcondition(guard_.handle(), true); }

 private:
  Entity waitset_, guard_;
};

bool is_matched(dds_entity_t reader, dds_instance_handle_t writer) noexcept {
  dds_builtintopic_endpoint_t* endpoint = dds_get_matched_publication_data(reader, writer);
  if (endpoint == nullptr) return false;
  dds_builtintopic_free_endpoint(endpoint);
  return true;
}

/// Who writes: the process (its DDS participant), and the strength that it offers.
struct Owner {
  dds_instance_handle_t participant;
  std::int32_t strength;
};
Owner owner_of(dds_entity_t reader, dds_instance_handle_t writer) noexcept {
  Owner owner{writer, 0};
  dds_builtintopic_endpoint_t* endpoint = dds_get_matched_publication_data(reader, writer);
  if (endpoint == nullptr) return owner;  // it has gone already
  owner.participant = endpoint->participant_instance_handle;
  if (endpoint->qos != nullptr) dds_qget_ownership_strength(endpoint->qos, &owner.strength);
  dds_builtintopic_free_endpoint(endpoint);
  return owner;
}

constexpr int kBusPriority = 60;  // servo threads run at 70 and above

/// While it lives, threads made by the calling one (Cyclone's) inherit the bus's priority.
class BusPriority {
 public:
  explicit BusPriority(bool wanted) noexcept {
    pthread_getschedparam(pthread_self(), &policy_, &before_);
    if (wanted) raise_to_bus_priority();
  }
  ~BusPriority() { pthread_setschedparam(pthread_self(), policy_, &before_); }
  BusPriority(const BusPriority&) = delete;
  BusPriority& operator=(const BusPriority&) = delete;

 private:
  int policy_ = SCHED_OTHER;
  sched_param before_{};
};

}  // namespace

void raise_to_bus_priority() noexcept {
  sched_param fifo{};
  fifo.sched_priority = kBusPriority;
  pthread_setschedparam(pthread_self(), SCHED_FIFO, &fifo);
}

Entity& Entity::operator=(Entity&& other) noexcept {
  std::swap(handle_, other.handle_);
  return *this;
}

Entity::~Entity() {
  if (handle_ > 0) dds_delete(handle_);
}

struct Bus::Implementation {
  explicit Implementation(const BusSettings& s) : settings(s), session(s.session_id) {
    if (s.exchange != nullptr) {
      if (s.clock == ClockMode::kRealtime)
        throw WireError("a bus within one process has no clock but lockstep's");
      identity = s.exchange->identity();
      return;
    }
    domain.emplace(s.domain, s.profile_uri, s.identity);
    join();
    waiter.emplace(participant.handle(), "the bus");
    peers.emplace(participant.handle());
  }

  void join() {
    std::optional<Complaints> complaints;
    if (domain->secure()) complaints.emplace();
    const dds_entity_t handle = dds_create_participant(settings.domain, nullptr, nullptr);
    if (handle < 0 && complaints) {
      throw ProfileError(read_profile(settings.profile_uri).name + ": the keys of " +
                         settings.identity + " in " + keys_directory().string() +
                         " were refused: " + complaints->first() +
                         "; c3rt keys check says what is wrong with them");
    }
    participant = created(handle, "a participant in DDS domain " + std::to_string(settings.domain));
  }

  void add(const Endpoint& endpoint) {
    const std::lock_guard lock(endpoints_mutex);
    endpoints.push_back(endpoint);
  }
  void remove(std::int32_t handle) {
    const std::lock_guard lock(endpoints_mutex);
    endpoints.erase(
        std::remove_if(endpoints.begin(), endpoints.end(),
                       [handle](const Endpoint& endpoint) { return endpoint.handle == handle; }),
        endpoints.end());
  }

  /// Whether a new writer of that topic may tell of a new plant. What moves the robot goes first:
  /// once the robot's state has been heard, no scene tells of another plant.
  bool may_tell(int stream) const noexcept {
    return settings.session_id == 0 &&
           (stream == kRobotState || session_told_by.load() != kRobotState);
  }
  void adopt(std::uint64_t id, int told_by) noexcept {
    if (!may_tell(told_by)) return;
    session_told_by.store(told_by);
    session.store(id);
  }

  BusSettings settings;
  std::atomic<int> session_told_by{kNoStream};
  std::atomic<std::uint64_t> session;
  std::array<std::atomic<std::uint64_t>, c3rt_v2_TOPIC_COUNT> written{};
  bool held_back = false;
  std::uint64_t identity = 0;  // within one process
  // of DDS alone
  std::optional<Domain> domain;
  Entity participant;
  std::optional<Waiter> waiter;
  std::optional<Peers> peers;

  std::vector<ReaderBase*> readers;  // those that wake the bus
  std::mutex endpoints_mutex;
  std::vector<Endpoint> endpoints;
  std::vector<const ReaderBase*> all_readers;  // under the same mutex
};

Bus::Bus(const BusSettings& settings) {
  const BusPriority inherited(settings.clock == ClockMode::kRealtime);
  implementation_ = std::make_unique<Implementation>(settings);
}
Bus::~Bus() = default;

std::int32_t Bus::participant() const { return implementation_->participant.handle(); }
ClockMode Bus::clock() const { return implementation_->settings.clock; }
std::uint64_t Bus::identity() const noexcept { return implementation_->identity; }
std::uint64_t Bus::session_id() const noexcept {
  return implementation_->session.load(std::memory_order_relaxed);
}

void Bus::adopt_session(std::uint64_t id) noexcept { implementation_->adopt(id, kRobotState); }

std::vector<PeerProblem> Bus::problems() const {
  if (!implementation_->peers) return {};
  const std::lock_guard lock(implementation_->endpoints_mutex);
  return implementation_->peers->problems(implementation_->endpoints);
}

std::vector<RefusedCount> Bus::refusals() const {
  const std::lock_guard lock(implementation_->endpoints_mutex);
  std::vector<RefusedCount> result;
  for (const ReaderBase* reader : implementation_->all_readers) {
    for (int i = 1; i < kReasonCount; ++i) {
      const RefusedCount found = reader->refusal(static_cast<Reason>(i));
      if (found.count == 0) continue;
      const auto same = std::find_if(result.begin(), result.end(), [&](const RefusedCount& known) {
        return known.topic == found.topic && known.reason == found.reason;
      });
      // several readers of one topic have refused the same samples
      if (same == result.end()) {
        result.push_back(found);
      } else if (same->count < found.count) {
        *same = found;
      }
    }
  }
  return result;
}

void Bus::wait_for_data(std::int64_t timeout_ns) {
  int arrived = 0;
  for (ReaderBase* reader : implementation_->readers) arrived += reader->pump();
  if (arrived == 0 && implementation_->waiter) implementation_->waiter->wait(timeout_ns);
}

void Bus::wake() noexcept {
  if (implementation_->waiter) implementation_->waiter->interrupt();
}

bool Bus::wait_for(const Sequences& newest_seq, std::int64_t timeout_ns, std::string& missing) {
  const std::int64_t deadline_ns = rt::now_ns() + timeout_ns;
  while (true) {
    const ReaderBase* behind = nullptr;
    for (ReaderBase* reader : implementation_->readers) {
      reader->pump();
      if (reader->topic_.stream == kNoStream) continue;
      const std::uint64_t promised = newest_seq[reader->topic_.stream];
      reader->allow(promised);
      if (!reader->has_come(promised)) behind = reader;
    }
    if (behind == nullptr) return true;
    const std::int64_t left_ns = deadline_ns - rt::now_ns();
    // within one process nothing is on its way
    if (left_ns <= 0 || !implementation_->waiter) {
      missing = behind->topic_.name;
      return false;
    }
    implementation_->waiter->wait(left_ns);
  }
}

void Bus::hold_until_promised() noexcept {
  implementation_->held_back = true;
  for (ReaderBase* reader : implementation_->readers) reader->allow(0);
}

void Bus::newest_written(Sequences& newest_seq) const noexcept {
  for (int i = 0; i < c3rt_v2_TOPIC_COUNT; ++i) newest_seq[i] = implementation_->written[i].load();
}

WriterBase::WriterBase(Bus& bus, const Topic& topic, std::optional<Process> addressee)
    : bus_(bus), topic_(topic), exchange_(bus.implementation_->settings.exchange.get()) {
  if (exchange_ != nullptr) {
    identity_ = exchange_->identity();
    exchange_->add_writer(topic_, identity_);
    // one that comes after another goes on counting: what was promised of a stream stays behind it
    if (topic.stream != kNoStream) seq_ = bus.implementation_->written[topic.stream].load();
    return;
  }
  const std::string name = topic.name;
  topic_entity_ =
      created(dds_create_topic(bus.participant(), topic.descriptor, topic.name, nullptr, nullptr),
              "topic " + name);
  writer_ = created(dds_create_writer(bus.participant(), topic_entity_.handle(),
                                      writer_qos(topic, bus.clock(), addressee).get(), nullptr),
                    "the writer of " + name);
  bus.implementation_->add({&topic_, writer_.handle(), true});
}

WriterBase::~WriterBase() {
  if (exchange_ != nullptr) {
    exchange_->remove_writer(topic_, identity_);
  } else {
    bus_.implementation_->remove(writer_.handle());
  }
}

int WriterBase::matched_readers() const {
  if (exchange_ != nullptr) return exchange_->readers(topic_);
  dds_publication_matched_status_t status{};
  dds_get_publication_matched_status(writer_.handle(), &status);
  return static_cast<int>(status.current_count);
}

bool WriterBase::write_sample(Header& header, void* sample, std::int64_t time_ns) noexcept {
  if (exchange_ != nullptr && !exchange_->passes(topic_, sample)) return true;
  const std::uint64_t seq = seq_.load(std::memory_order_relaxed) + 1;
  header.session_id = bus_.session_id();
  header.seq = seq;
  header.time_ns = time_ns;
  if (exchange_ != nullptr) {
    exchange_->put(topic_, sample, {identity_, bus_.implementation_->identity}, seq);
  } else if (dds_write(writer_.handle(), sample) != DDS_RETCODE_OK) {
    return false;
  }
  seq_.store(seq);
  if (topic_.stream != kNoStream) bus_.implementation_->written[topic_.stream].store(seq);
  return true;
}

/// What was accepted from one writer.
struct ReaderBase::Source {
  dds_instance_handle_t writer = 0;
  std::uint64_t session = 0;
  Owner owner{0, 0};
  std::uint64_t newest = 0;  // of the pumps before this one; 0: new
  std::uint64_t first_arrived = 0, last_arrived = 0, arrived = 0;  // in this pump
};

struct ReaderBase::Implementation {
  Implementation(const Bus& bus, const Topic& of)
      : topic_of(of),
        one_writer(silence_ns(bus, of),
                   // no stranger enters a run that shall give the same bits every time
                   bus.clock() == ClockMode::kLockstep ? kProcessStrength
                                                       : std::numeric_limits<std::int32_t>::min()) {
  }

  static std::int64_t silence_ns(const Bus& bus, const Topic& of) {
    if (bus.clock() == ClockMode::kLockstep) return 0;
    const double seconds = of.deadline_s > 0.0 ? kMissedDeadlines * of.deadline_s : kSilence_s;
    return static_cast<std::int64_t>(seconds * 1e9);
  }

  struct Entry {
    int slot;
    int source;
    std::uint64_t session, seq;
    dds_instance_handle_t writer;
  };
  dds_instance_handle_t taken_from = 0;
  static constexpr int kSources = 32;

  /// The next sample that has arrived. @return false if there is none
  bool next(void* sample, Sender& sender) noexcept {
    if (exchange != nullptr) return exchange->take(*inbox, sample, sender);
    dds_sample_info_t info;
    while (dds_take(reader.handle(), &sample, &info, 1, 1) == 1) {
      if (!info.valid_data) continue;  // a writer came or went
      if (info.source_timestamp < not_before && rt::now_ns() < history_until_ns) continue;
      sender = {info.publication_handle, 0};
      return true;
    }
    return false;
  }
  Owner owner(const Sender& sender) const noexcept {
    return exchange != nullptr ? Owner{sender.bus, kProcessStrength}
                               : owner_of(reader.handle(), sender.writer);
  }

  Source& source_of(const Sender& sender, std::uint64_t session) noexcept {
    const std::uint64_t writer = sender.writer;
    for (Source& source : sources) {
      if (source.writer != writer) continue;
      if (source.session != session) source = {writer, session, source.owner};
      return source;
    }
    // more writers than places: the oldest place is reused, and that writer's next gap goes
    // unnoticed
    Source& source = sources[next_source];
    next_source = (next_source + 1) % kSources;
    source = {writer, session, owner(sender)};
    return source;
  }
  bool is_matched(std::uint64_t writer) const noexcept {
    return exchange != nullptr ? exchange->has_writer(topic_of, writer)
                               : wire::is_matched(reader.handle(), writer);
  }
  bool leader_is_there() const noexcept {
    return std::any_of(sources.begin(), sources.end(), [this](const Source& source) {
      return source.writer != 0 && source.owner.participant == one_writer.leader() &&
             is_matched(source.writer);
    });
  }
  Entry& entry(int i) noexcept { return entries[static_cast<std::size_t>((head + i) % capacity)]; }
  /// The same number of the same writer is among the newest entries, which are in order.
  bool has_fresh(const Source& source, std::uint64_t seq, int fresh) noexcept {
    for (int i = count - 1; i >= count - fresh; --i) {
      const Entry& known = entry(i);
      if (&sources[static_cast<std::size_t>(known.source)] != &source) continue;
      if (known.seq <= seq) return known.seq == seq;
    }
    return false;
  }

  const Topic& topic_of;
  // within one process
  Exchange* exchange = nullptr;
  std::unique_ptr<Inbox> inbox;
  // of DDS
  Entity topic, reader, condition;
  /// Requests and faults from before a process was there were for its predecessor: their writers,
  /// who live on, offer them again to whoever is started. A target stays until the next one.
  dds_time_t not_before = std::numeric_limits<dds_time_t>::min();  // of the wall's clock
  /// What was kept comes as its writer is found. Later on a client's clock may be behind ours.
  std::int64_t history_until_ns = 0;
  std::unique_ptr<Waiter> waiter;  // Wakes::kItself

  OneWriter one_writer;
  std::array<Source, kSources> sources{};
  int next_source = 0;

  // a ring of `capacity` entries; each owns one slot of the samples, also while it is not in use
  std::vector<Entry> entries;
  int capacity = 0, head = 0, count = 0;
  std::uint64_t allowed = kNoLimit;  // sequence number up to which a stream's samples are given out

  std::atomic<std::uint64_t> received{0}, lost{0};

  /// The newest refusal for one reason that was looked at.
  struct Finding {
    Refusal refusal;
    std::uint64_t session = 0;   // that the sample named
    std::uint64_t expected = 0;  // that it should have
    dds_instance_handle_t writer = 0;
    std::string from;
    std::string obeyed;  // of a second writer: the first
  };
  std::array<std::atomic<std::uint64_t>, kReasonCount> refused{};
  mutable std::mutex findings_mutex;
  std::array<Finding, kReasonCount> findings;
};

int ReaderBase::queue_depth(const Bus& bus, const Topic& topic, int depth) {
  const bool lockstep =
      bus.clock() == ClockMode::kLockstep && topic.qos != Qos::kEvent && topic.qos != Qos::kStatus;
  return lockstep ? std::max(depth, kLockstepDepth) : std::max(depth, 1);
}

ReaderBase::ReaderBase(Bus& bus, const Topic& topic, int depth, Wakes wakes,
                       std::optional<Process> addressee)
    : bus_(bus), topic_(topic), implementation_(std::make_unique<Implementation>(bus, topic)) {
  Implementation& self = *implementation_;
  const int kept = queue_depth(bus, topic, depth);
  self.capacity = kept + 1;
  self.entries.resize(static_cast<std::size_t>(self.capacity));
  for (int i = 0; i < self.capacity; ++i) self.entries[static_cast<std::size_t>(i)].slot = i;
  self.exchange = bus.implementation_->settings.exchange.get();
  if (self.exchange != nullptr) {
    self.inbox = std::make_unique<Inbox>(topic, bus.identity());
    newest_seq_ = self.exchange->add_reader(*self.inbox);  // nobody waits for what it cannot get
  } else {
    join_dds(kept, wakes, addressee);
  }
  if (wakes == Wakes::kBus) {
    bus.implementation_->readers.push_back(this);
    if (bus.implementation_->held_back && topic.stream != kNoStream) self.allowed = 0;
  }
  const std::lock_guard lock(bus.implementation_->endpoints_mutex);
  bus.implementation_->all_readers.push_back(this);
}

void ReaderBase::join_dds(int depth, Wakes wakes, std::optional<Process> addressee) {
  Implementation& self = *implementation_;
  const std::string name = topic_.name;
  const bool of_the_moment = topic_.trait == Trait::kAnswered && &topic_ != &topic<TaskTarget>();
  if (of_the_moment && bus_.clock() == ClockMode::kRealtime) {
    self.not_before = dds_time();
    self.history_until_ns = rt::now_ns() + kHistory_ns;
  }
  self.topic = created(
      dds_create_topic(bus_.participant(), topic_.descriptor, topic_.name, nullptr, nullptr),
      "topic " + name);
  self.reader =
      created(dds_create_reader(bus_.participant(), self.topic.handle(),
                                reader_qos(topic_, bus_.clock(), depth, addressee).get(), nullptr),
              "the reader of " + name);
  self.condition = created(dds_create_readcondition(self.reader.handle(), DDS_ANY_STATE),
                           "the read condition of " + name);
  if (wakes == Wakes::kBus) {
    bus_.implementation_->waiter->attach(self.condition);
  } else {
    self.waiter = std::make_unique<Waiter>(bus_.participant(), "the reader of " + name);
    self.waiter->attach(self.condition);
  }
  bus_.implementation_->add({&topic_, self.reader.handle(), false});
}

ReaderBase::~ReaderBase() {
  Implementation& self = *implementation_;
  {
    const std::lock_guard lock(bus_.implementation_->endpoints_mutex);
    auto& all = bus_.implementation_->all_readers;
    all.erase(std::remove(all.begin(), all.end(), this), all.end());
  }
  auto& readers = bus_.implementation_->readers;
  readers.erase(std::remove(readers.begin(), readers.end(), this), readers.end());
  if (self.exchange != nullptr) {
    self.exchange->remove_reader(*self.inbox);
    return;
  }
  bus_.implementation_->remove(self.reader.handle());
  if (self.waiter != nullptr) {
    self.waiter->detach(self.condition);
  } else {
    bus_.implementation_->waiter->detach(self.condition);
  }
}

ReaderCounters ReaderBase::counters() const noexcept {
  const Implementation& self = *implementation_;
  ReaderCounters counters{self.received.load(), self.lost.load(), {}};
  for (std::size_t i = 0; i < counters.refused.size(); ++i)
    counters.refused[i] = self.refused[i].load();
  return counters;
}

int ReaderBase::matched_writers() const {
  if (implementation_->exchange != nullptr) return implementation_->exchange->writers(topic_);
  dds_subscription_matched_status_t status{};
  dds_get_subscription_matched_status(implementation_->reader.handle(), &status);
  return static_cast<int>(status.current_count);
}

int ReaderBase::alive_writers() const {
  if (implementation_->exchange != nullptr) return matched_writers();
  dds_liveliness_changed_status_t status{};
  dds_get_liveliness_changed_status(implementation_->reader.handle(), &status);
  return static_cast<int>(status.alive_count);
}

std::uint64_t ReaderBase::missed_deadlines() const {
  if (implementation_->exchange != nullptr) return 0;
  dds_requested_deadline_missed_status_t status{};
  dds_get_requested_deadline_missed_status(implementation_->reader.handle(), &status);
  return status.total_count;
}

void ReaderBase::wait(std::int64_t timeout_ns) {
  if (implementation_->waiter) implementation_->waiter->wait(timeout_ns);
}
void ReaderBase::interrupt() noexcept {
  if (implementation_->waiter) implementation_->waiter->interrupt();
}

void ReaderBase::allow(std::uint64_t seq) noexcept {
  if (topic_.stream != kNoStream) implementation_->allowed = seq;
}

bool ReaderBase::has_come(std::uint64_t seq) const {
  const Implementation& self = *implementation_;
  return newest_seq_ >= seq ||
         (self.exchange != nullptr && self.exchange->sent(*self.inbox) >= seq);
}

Reason ReaderBase::judge(const Header& header, const Source& source, std::int64_t now_ns) noexcept {
  Implementation& self = *implementation_;
  const std::uint64_t ours = bus_.session_id();
  const std::uint64_t theirs = header.session_id;
  // what paces a run comes from its own processes alone
  if (topic_.qos == Qos::kSync && source.owner.strength < kProcessStrength)
    return Reason::kSecondWriter;
  if (!topic_.writer) {
    // a client may know no session, and neither does a process that has not heard the plant
    return theirs == 0 || ours == 0 || theirs == ours ? Reason::kNone : Reason::kOtherSession;
  }
  // a session begins with the plant, so it is told by whom this process takes for the plant, and by
  // nobody else; a plant that was started again is another writer
  Bus::Implementation& bus = *bus_.implementation_;
  const bool of_plant = topic_.writer == c3rt_v2_PROCESS_PLANT;
  const bool new_plant = of_plant && bus.may_tell(topic_.stream) &&
                         source.owner.participant != self.one_writer.leader();
  if (theirs == 0 || (theirs != ours && ours != 0 && !new_plant)) {
    return self.one_writer.has_other_than(source.owner.participant, now_ns) ? Reason::kSecondWriter
                                                                            : Reason::kOtherSession;
  }
  const Owner& owner = source.owner;
  bool admitted = self.one_writer.admits(owner.participant, owner.strength, now_ns);
  if (!admitted && self.one_writer.leader_is_silent(now_ns) && !self.leader_is_there()) {
    self.one_writer.retire();
    admitted = self.one_writer.admits(owner.participant, owner.strength, now_ns);
  }
  if (!admitted) return Reason::kSecondWriter;
  if (of_plant && theirs != ours) bus.adopt(theirs, topic_.stream);
  return Reason::kNone;
}

void ReaderBase::refuse(const Refusal& refusal, const Header& header,
                        const Source& source) noexcept {
  Implementation& self = *implementation_;
  const auto reason = static_cast<std::size_t>(refusal.reason);
  self.refused[reason].fetch_add(1, std::memory_order_relaxed);
  // what is being read is not waited for: the next refusal comes
  const std::unique_lock lock(self.findings_mutex, std::try_to_lock);
  if (!lock) return;
  Implementation::Finding& finding = self.findings[reason];
  finding.refusal = refusal;
  finding.session = header.session_id;
  finding.expected = bus_.session_id();
  if (finding.writer == source.writer) return;
  finding.writer = source.writer;
  finding.from = name_of_writer(source.writer);
  finding.obeyed = "a process of the run alone";
  for (const Source& other : self.sources) {
    if (other.writer != 0 && other.owner.participant == self.one_writer.leader())
      finding.obeyed = name_of_writer(other.writer);
  }
}

RefusedCount ReaderBase::refusal(Reason reason) const {
  const Implementation& self = *implementation_;
  const auto i = static_cast<std::size_t>(reason);
  RefusedCount result{topic_.name, reason, self.refused[i].load(), "", ""};
  if (result.count == 0) return result;
  const std::lock_guard lock(self.findings_mutex);
  const Implementation::Finding& finding = self.findings[i];
  result.from = finding.from;
  result.latest = to_text(finding.refusal);
  if (reason == Reason::kSecondWriter) result.latest = "obeyed is " + finding.obeyed;
  if (reason == Reason::kOtherSession) {
    result.latest = "session " + std::to_string(finding.session) + ", expected " +
                    (finding.expected == 0 ? "the plant's" : std::to_string(finding.expected));
  }
  return result;
}

int ReaderBase::pump() noexcept {
  Implementation& self = *implementation_;
  const bool realtime = bus_.clock() == ClockMode::kRealtime;
  int fresh = 0;  // entries of this pump, at the end of the queue
  int accepted = 0;
  bool any = false;
  while (true) {
    // the entry behind the last one owns a free slot
    const int slot = self.entry(self.count).slot;
    Sender sender{};
    if (!self.next(sample_at(slot), sender)) break;
    const Header& header = header_at(slot);
    Source& source = self.source_of(sender, header.session_id);
    const std::int64_t now_ns = realtime ? rt::now_ns() : 0;
    const std::int64_t latest_ns = realtime && bus_.implementation_->settings.shares_clock
                                       ? now_ns + kAhead_ns
                                       : std::numeric_limits<std::int64_t>::max();
    Refusal refusal = validate(header, topic_.writer.has_value(), latest_ns);
    const Refusal value = refusal ? Refusal{} : check(slot);
    // nonsense makes nobody the writer of a topic
    const bool stranger = topic_.writer && source.owner.participant != self.one_writer.leader();
    if (stranger && value) refusal = value;
    if (!refusal) refusal.reason = judge(header, source, now_ns);
    if (!refusal && (header.seq <= source.newest || self.has_fresh(source, header.seq, fresh)))
      refusal.reason = Reason::kOldSequence;
    if (refusal) {
      refuse(refusal, header, source);
      keep_refused(slot, refusal);
      continue;
    }
    // it has arrived, whether it is of use or not
    any = true;
    source.first_arrived =
        source.arrived == 0 ? header.seq : std::min(source.first_arrived, header.seq);
    source.last_arrived = std::max(source.last_arrived, header.seq);
    ++source.arrived;
    if (value) {
      refuse(value, header, source);
      keep_refused(slot, value);
      continue;
    }
    Implementation::Entry& entry = self.entry(self.count);
    entry.source = static_cast<int>(&source - self.sources.data());
    entry.session = header.session_id;
    entry.seq = header.seq;
    entry.writer = sender.writer;
    ++self.count;
    ++fresh;
    ++accepted;
    // DDS hands out instance by instance: back into the order in which the writer wrote
    for (int i = self.count - 1; i > self.count - fresh; --i) {
      Implementation::Entry& before = self.entry(i - 1);
      if (before.source != self.entry(i).source || before.seq < self.entry(i).seq) break;
      std::swap(before, self.entry(i));
    }
    if (self.count == self.capacity) {
      pop();
      fresh = std::min(fresh, self.count);
    }
  }
  if (!any) return 0;
  self.received.fetch_add(static_cast<std::uint64_t>(accepted), std::memory_order_relaxed);
  for (Source& source : self.sources) {
    if (source.arrived == 0) continue;
    // what a writer wrote before it was first heard is not lost
    const std::uint64_t expected =
        source.last_arrived - (source.newest == 0 ? source.first_arrived - 1 : source.newest);
    if (expected > source.arrived)
      self.lost.fetch_add(expected - source.arrived, std::memory_order_relaxed);
    source.newest = source.last_arrived;
    const std::uint64_t ours = bus_.session_id();
    const bool leads = !topic_.writer || source.owner.participant == self.one_writer.leader();
    if (leads && (source.session == ours || source.session == 0 || ours == 0))
      newest_seq_ = source.newest;
    source.arrived = 0;
  }
  return accepted;
}

int ReaderBase::front() noexcept {
  Implementation& self = *implementation_;
  while (self.count > 0) {
    const Implementation::Entry& entry = self.entry(0);
    // the plant may have restarted since the sample was queued, or been heard for the first time
    const std::uint64_t ours = bus_.session_id();
    if (entry.session != 0 && ours != 0 && entry.session != ours) {
      refuse({Reason::kOtherSession}, header_at(entry.slot),
             self.sources[static_cast<std::size_t>(entry.source)]);
      pop();
      continue;
    }
    return entry.seq <= self.allowed ? entry.slot : -1;
  }
  return -1;
}

void ReaderBase::pop() noexcept {
  Implementation& self = *implementation_;
  self.taken_from = self.entry(0).writer;
  self.head = (self.head + 1) % self.capacity;
  --self.count;
}

std::uint64_t ReaderBase::taken_from() const noexcept { return implementation_->taken_from; }
std::string ReaderBase::name_of_writer(std::uint64_t writer) const {
  const Peers* const peers = bus_.implementation_->peers ? &*bus_.implementation_->peers : nullptr;
  return peers == nullptr ? "this process"
                          : peers->name_of_writer(implementation_->reader.handle(), writer);
}

}  // namespace c3rt::wire
