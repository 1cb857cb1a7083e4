// Prints where the end effector is: a reader of robot/state with Cyclone DDS's C interface.
#include <cstdio>
#include <cstdlib>

#include <dds/dds.h>

#include "c3rt.h"  // idlc -l c c3rt.idl

int main(int argc, char** argv) {
  const auto domain = static_cast<dds_domainid_t>(argc > 1 ? std::atoi(argv[1]) : 0);
  const dds_entity_t participant = dds_create_participant(domain, nullptr, nullptr);
  const dds_entity_t topic =
      dds_create_topic(participant, &c3rt_v2_RobotState_desc, "robot/state", nullptr, nullptr);
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_BEST_EFFORT, 0);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 100);
  const dds_entity_t reader = dds_create_reader(participant, topic, qos, nullptr);
  dds_delete_qos(qos);
  const dds_entity_t waitset = dds_create_waitset(participant);
  dds_waitset_attach(waitset, dds_create_readcondition(reader, DDS_ANY_STATE), 0);
  if (reader < 0) return 1;
  while (dds_waitset_wait(waitset, nullptr, 0, DDS_SECS(5)) > 0) {
    c3rt_v2_RobotState state;
    void* sample = &state;
    dds_sample_info_t info;
    while (dds_take(reader, &sample, &info, 1, 1) == 1) {
      if (!info.valid_data) continue;  // a writer came or went
      std::printf("%llu %lld [%.4f, %.4f, %.4f]\n",
                  static_cast<unsigned long long>(state.header.seq),
                  static_cast<long long>(state.header.time_ns), state.p_WE_m[0], state.p_WE_m[1],
                  state.p_WE_m[2]);
    }
  }
  std::fprintf(stderr, "nobody has written robot/state for 5 s\n");
  return 1;
}
