/* One cell of the matrix of docs/clients.md, in C and, compiled as such, in C++: reads robot/state for a second and a plan,
 * gives the planner a circle, and says what came. Cyclone DDS's C interface and idlc -l c idl/c3rt.idl.
 *
 *   client DOMAIN */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <dds/dds.h>

#include "c3rt.h"

static dds_entity_t reader_of(dds_entity_t participant, const dds_topic_descriptor_t* type, const char* name, int reliable) {
  const dds_entity_t topic = dds_create_topic(participant, type, name, NULL, NULL);
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT, DDS_MSECS(100));
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 100);
  const dds_entity_t reader = dds_create_reader(participant, topic, qos, NULL);
  dds_delete_qos(qos);
  return reader;
}

static int take(dds_entity_t reader, void* sample) {
  dds_sample_info_t info;
  while (dds_take(reader, &sample, &info, 1, 1) == 1)
    if (info.valid_data) return 1;
  return 0;
}

static void give(c3rt_v2_TaskTarget* target, int index, const char* name, int count, double first, double second) {
  c3rt_v2_TargetParameter* parameter = &target->parameters[index];
  snprintf(parameter->name, sizeof parameter->name, "%s", name);
  parameter->value_count = count;
  parameter->values[0] = first;
  parameter->values[1] = second;
}

int main(int argc, char** argv) {
  const dds_domainid_t domain = (dds_domainid_t)(argc > 1 ? atoi(argv[1]) : 0);
  const dds_entity_t participant = dds_create_participant(domain, NULL, NULL);
  const dds_entity_t states = reader_of(participant, &c3rt_v2_RobotState_desc, "robot/state", 0);
  const dds_entity_t plans = reader_of(participant, &c3rt_v2_Plan_desc, "plan", 1);
  const dds_entity_t replies = reader_of(participant, &c3rt_v2_ServiceReply_desc, "service/reply", 1);
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
  dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
  const dds_entity_t targets = dds_create_writer(
      participant, dds_create_topic(participant, &c3rt_v2_TaskTarget_desc, "task/target", NULL, NULL), qos, NULL);
  dds_delete_qos(qos);
  if (participant < 0 || states < 0 || plans < 0 || replies < 0 || targets < 0) {
    fprintf(stderr, "no participant, reader or writer: is CYCLONEDDS_URI right?\n");
    return 1;
  }

  static c3rt_v2_RobotState state;
  static c3rt_v2_Plan plan;
  static c3rt_v2_TaskTarget target;
  static c3rt_v2_ServiceReply reply;
  unsigned long long count = 0, first = 0, last = 0;
  char phase[32] = "";
  dds_time_t until = dds_time() + DDS_SECS(15);
  while (dds_time() < until) {
    while (take(states, &state)) {
      if (count++ == 0) first = state.header.seq;
      last = state.header.seq;
    }
    if (take(plans, &plan)) snprintf(phase, sizeof phase, "%s", plan.phase);
    if (count >= 1000 && phase[0] != '\0') break;
    dds_sleepfor(DDS_MSECS(1));
  }
  target.header.seq = 1;
  target.request_id = 1 + (unsigned long long)dds_time();
  snprintf(target.kind, sizeof target.kind, "circle");
  target.parameter_count = 3;
  give(&target, 0, "center_m", 2, 0.55, 0.0);
  give(&target, 1, "radius_m", 1, 0.08, 0.0);
  give(&target, 2, "lead_rad", 1, 0.349, 0.0);
  dds_write(targets, &target);
  for (until = dds_time() + DDS_SECS(10); dds_time() < until; dds_sleepfor(DDS_MSECS(5))) {
    while (take(replies, &reply)) {
      if (reply.request_id != target.request_id) continue;
      printf("%llu states of %llu, plan \"%s\", %s: %s\n", count, last - first + 1, phase, reply.ok ? "ok" : "refused", reply.text);
      dds_delete(participant); /* before OpenSSL's own end, which its threads would not outlive */
      return count >= 100 && phase[0] != '\0' && reply.ok ? 0 : 1;
    }
  }
  fprintf(stderr, "%llu states of %llu, plan \"%s\", no reply\n", count, count == 0 ? 0 : last - first + 1, phase);
  return 1;
}
