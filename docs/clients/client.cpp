// Reads where the planner wants the end effector, and gives it another circle:
// find_package(c3rt REQUIRED COMPONENTS client), target_link_libraries(... c3rt::client)
#include "idl/client/client.hpp"

#include <cstdio>
#include <cstdlib>

int main(int argc, char** argv) try {
  using namespace c3rt;
  client::Client robot(argc > 1 ? std::atoi(argv[1]) : 0);  // domain 0 and profile loopback
  const auto plan = robot.newest<wire::Plan>();
  std::printf("%s at height %.4f\n", plan.phase, plan.knots[0].p_WE_m[2]);
  const client::Reply reply = robot.target(
      "circle", {{"center_m", {0.55, 0.0}}, {"radius_m", {0.08}}, {"lead_rad", {0.349}}});
  std::printf("%s\n", reply.text.c_str());
  client::Reader<wire::RobotState> states(robot.bus(), 100);
  for (wire::RobotState state{}; states.wait(state, 1.0);)  // each, until none came for a second
    std::printf("%llu %.4f\n", static_cast<unsigned long long>(state.header.seq), state.p_WE_m[2]);
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
