#include "idl/peers.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include <unistd.h>

#include "controller/rt/periodic_clock.hpp"
#include "idl/discovery.hpp"

namespace c3rt::wire {

namespace {

constexpr int kMaxPeers = 4096;  // endpoints of 120 participants that live
constexpr std::int64_t kMatchingTime_ns = 2'000'000'000;

Entity builtin_reader(std::int32_t participant, dds_entity_t topic) {
  return Entity(dds_create_reader(participant, topic, nullptr, nullptr));
}

/// Reads every living instance of a built-in topic; the loan ends with the object. What is left of
/// those that have gone is taken first: a reader keeps it until then, 4 kB of every client that
/// came and went, and in time more than a look can read.
template <typename T>
class Loan {
 public:
  explicit Loan(std::int32_t reader) : reader_(reader) {
    do {
      count_ = dds_take_mask(reader_, samples_.data(), info_.data(), kMaxPeers, kMaxPeers, kGone);
      give_back();
    } while (count_ == kMaxPeers);
    count_ = dds_read(reader_, samples_.data(), info_.data(), kMaxPeers, kMaxPeers);
  }
  ~Loan() { give_back(); }
  Loan(const Loan&) = delete;
  Loan& operator=(const Loan&) = delete;

  template <typename F>
  void each(F visit) const {
    for (int i = 0; i < count_; ++i) {
      const auto at = static_cast<std::size_t>(i);
      if (info_[at].valid_data && info_[at].instance_state == DDS_IST_ALIVE) {
        visit(*static_cast<const T*>(samples_[at]), info_[at].instance_handle);
      }
    }
  }

 private:
  static constexpr std::uint32_t kGone = DDS_ANY_SAMPLE_STATE | DDS_ANY_VIEW_STATE |
                                         DDS_NOT_ALIVE_DISPOSED_INSTANCE_STATE |
                                         DDS_NOT_ALIVE_NO_WRITERS_INSTANCE_STATE;

  void give_back() {
    if (count_ > 0) dds_return_loan(reader_, samples_.data(), count_);
  }

  std::int32_t reader_;
  int count_ = 0;
  // of one size for every loan: Cyclone fills as much as the reader ever lent
  std::vector<void*> samples_ = std::vector<void*>(kMaxPeers);
  std::vector<dds_sample_info_t> info_ = std::vector<dds_sample_info_t>(kMaxPeers);
};

std::string property(const dds_qos_t* qos, const char* key) {
  char* value = nullptr;
  if (!dds_qget_prop(qos, key, &value) || value == nullptr) return "";
  std::string result(value);
  dds_free(value);
  return result;
}

std::vector<dds_instance_handle_t> matched(const Endpoint& endpoint) {
  std::vector<dds_instance_handle_t> handles(kMaxPeers);
  const dds_return_t count =
      endpoint.is_writer
          ? dds_get_matched_subscriptions(endpoint.handle, handles.data(), handles.size())
          : dds_get_matched_publications(endpoint.handle, handles.data(), handles.size());
  handles.resize(count > 0 ? std::min<std::size_t>(static_cast<std::size_t>(count), handles.size())
                           : 0);
  return handles;
}

}  // namespace

std::string host_name() {
  char name[256] = "";
  gethostname(name, sizeof name - 1);
  return name;
}

std::vector<PeerEndpoint> peer_endpoints(const Bus& bus) {
  struct Name {
    std::string process, host;
    int pid = 0;
  };
  const Entity publications = builtin_reader(bus.participant(), DDS_BUILTIN_TOPIC_DCPSPUBLICATION),
               subscriptions =
                   builtin_reader(bus.participant(), DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION),
               participants = builtin_reader(bus.participant(), DDS_BUILTIN_TOPIC_DCPSPARTICIPANT);
  dds_guid_t own{};
  dds_get_guid(bus.participant(), &own);
  std::map<std::string, Name> names;  // by the participant's key
  const auto key = [](const dds_guid_t& guid) {
    return std::string(reinterpret_cast<const char*>(guid.v), sizeof guid.v);
  };
  Loan<dds_builtintopic_participant_t>(participants.handle())
      .each([&](const auto& peer, dds_instance_handle_t) {
        names[key(peer.key)] = {property(peer.qos, "__ProcessName"),
                                property(peer.qos, "__Hostname"),
                                std::atoi(property(peer.qos, "__Pid").c_str())};
      });
  std::vector<PeerEndpoint> result;
  const auto add = [&](const dds_builtintopic_endpoint_t& peer, bool is_writer) {
    if (std::memcmp(peer.participant_key.v, own.v, sizeof own.v) == 0) return;
    const Name& name = names[key(peer.participant_key)];
    result.push_back({peer.topic_name, peer.type_name, is_writer, name.process, name.host, name.pid,
                      describe(peer.qos)});
  };
  Loan<dds_builtintopic_endpoint_t>(publications.handle())
      .each([&](const auto& peer, dds_instance_handle_t) { add(peer, true); });
  Loan<dds_builtintopic_endpoint_t>(subscriptions.handle())
      .each([&](const auto& peer, dds_instance_handle_t) { add(peer, false); });
  return result;
}

std::vector<PeerProblem> peer_disagreements(const Bus& bus) {
  struct Known {
    std::string topic, type, owner, participant;
    QosPointer qos;
  };
  const Peers peers(bus.participant());
  dds_guid_t own{};
  dds_get_guid(bus.participant(), &own);
  const auto known = [&](dds_entity_t topic) {
    std::vector<Known> all;
    const Entity reader = builtin_reader(bus.participant(), topic);
    Loan<dds_builtintopic_endpoint_t>(reader.handle())
        .each([&](const auto& peer, dds_instance_handle_t) {
          const bool ours = with_topic(peer.topic_name, [](const auto&) {});
          if (!ours || std::memcmp(peer.participant_key.v, own.v, sizeof own.v) == 0) return;
          QosPointer qos(dds_create_qos());
          dds_copy_qos(qos.get(), peer.qos);
          all.push_back({peer.topic_name, peer.type_name, peers.name_of(peer.participant_key),
                         std::string(reinterpret_cast<const char*>(peer.participant_key.v),
                                     sizeof peer.participant_key.v),
                         std::move(qos)});
        });
    return all;
  };
  const std::vector<Known> writers = known(DDS_BUILTIN_TOPIC_DCPSPUBLICATION),
                           readers = known(DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION);
  std::vector<PeerProblem> result;
  for (const Known& writer : writers) {
    for (const Known& reader : readers) {
      if (writer.topic != reader.topic || writer.participant == reader.participant) continue;
      Disagreement difference{"has type " + writer.type, "has type " + reader.type};
      if (writer.type == reader.type) {
        if (!disagree(writer.qos.get(), reader.qos.get(), difference)) continue;
        difference = {"offers " + difference.offered, "requests " + difference.requested};
      }
      result.push_back({writer.topic, writer.topic + ": the writer of " + writer.owner + " " +
                                          difference.offered + ", the reader of " + reader.owner +
                                          " " + difference.requested});
    }
  }
  return result;
}

Peers::Peers(std::int32_t participant)
    : participant_(participant),
      publications_(builtin_reader(participant, DDS_BUILTIN_TOPIC_DCPSPUBLICATION)),
      subscriptions_(builtin_reader(participant, DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION)),
      participants_(builtin_reader(participant, DDS_BUILTIN_TOPIC_DCPSPARTICIPANT)) {}

std::string Peers::name_of(const dds_guid_t& participant) const {
  std::string name = "another process";
  Loan<dds_builtintopic_participant_t>(participants_.handle())
      .each([&](const auto& peer, dds_instance_handle_t) {
        if (std::memcmp(peer.key.v, participant.v, sizeof participant.v) != 0) return;
        const std::string process = property(peer.qos, "__ProcessName");
        const std::string pid = property(peer.qos, "__Pid");
        if (process.empty()) return;
        const std::string host = property(peer.qos, "__Hostname");
        name = process;
        if (!pid.empty())
          name += " (pid " + pid + (host.empty() || host == host_name() ? "" : " on " + host) + ")";
      });
  return name;
}

std::string Peers::name_of_writer(std::int32_t reader, std::uint64_t writer) const {
  dds_builtintopic_endpoint_t* endpoint = dds_get_matched_publication_data(reader, writer);
  if (endpoint == nullptr) return "a process that has gone";
  std::string name = name_of(endpoint->participant_key);
  dds_builtintopic_free_endpoint(endpoint);
  return name;
}

std::vector<PeerProblem> Peers::problems(const std::vector<Endpoint>& ours) {
  (void)Loan<dds_builtintopic_participant_t>(participants_.handle());  // forgets who has gone
  std::vector<PeerProblem> result;
  dds_guid_t own{};
  dds_get_guid(participant_, &own);
  decltype(unmatched_since_ns_) unmatched;
  const auto check = [&](const Endpoint& endpoint, const dds_builtintopic_endpoint_t& peer,
                         dds_instance_handle_t peer_handle) {
    const bool same_topic = std::strcmp(peer.topic_name, endpoint.topic->name) == 0;
    const bool same_type = std::strcmp(peer.type_name, endpoint.topic->descriptor->m_typename) == 0;
    if (!same_topic && !same_type) return;
    if (std::memcmp(peer.participant_key.v, own.v, sizeof own.v) == 0) return;
    const char* here = endpoint.is_writer ? "this writer" : "this reader";
    const char* there = endpoint.is_writer ? "reader" : "writer";
    const auto report = [&](const std::string& theirs, const std::string& mine) {
      result.push_back({endpoint.topic->name, std::string(endpoint.topic->name) + ": " + there +
                                                  " of " + name_of(peer.participant_key) + " " +
                                                  theirs + ", " + here + " " + mine});
    };
    const char* type = endpoint.topic->descriptor->m_typename;
    if (!same_topic) {
      report(std::string("of the same type is on the topic ") + peer.topic_name,
             "on " + std::string(endpoint.topic->name));
      return;
    }
    if (!same_type) {
      report(std::string("has type ") + peer.type_name, std::string("has type ") + type);
      return;
    }
    QosPointer qos(dds_create_qos());
    if (dds_get_qos(endpoint.handle, qos.get()) != DDS_RETCODE_OK) return;
    Disagreement difference;
    if (disagree(endpoint.is_writer ? qos.get() : peer.qos,
                 endpoint.is_writer ? peer.qos : qos.get(), difference)) {
      if (endpoint.is_writer) {
        report("requests " + difference.requested, "offers " + difference.offered);
      } else {
        report("offers " + difference.offered, "requests " + difference.requested);
      }
      return;
    }
    const auto partners = matched(endpoint);
    if (std::find(partners.begin(), partners.end(), peer_handle) != partners.end()) return;
    if (!same_addressee(qos.get(), peer.qos)) {
      if (endpoint.topic->trait != Trait::kAddressed)
        report("is in " + partitions(peer.qos), "in " + partitions(qos.get()));
      return;
    }
    const std::pair key(endpoint.handle, peer_handle);
    const auto known = unmatched_since_ns_.find(key);
    const std::int64_t since_ns = known == unmatched_since_ns_.end() ? rt::now_ns() : known->second;
    unmatched[key] = since_ns;
    if (rt::now_ns() - since_ns > kMatchingTime_ns) {
      report(std::string("defines ") + type + " differently", "cannot understand it");
    }
  };
  Loan<dds_builtintopic_endpoint_t>(publications_.handle())
      .each([&](const auto& peer, dds_instance_handle_t handle) {
        for (const Endpoint& endpoint : ours) {
          if (!endpoint.is_writer) check(endpoint, peer, handle);
        }
      });
  Loan<dds_builtintopic_endpoint_t>(subscriptions_.handle())
      .each([&](const auto& peer, dds_instance_handle_t handle) {
        for (const Endpoint& endpoint : ours) {
          if (endpoint.is_writer) check(endpoint, peer, handle);
        }
      });
  unmatched_since_ns_ = std::move(unmatched);
  return result;
}

}  // namespace c3rt::wire
