#include "cli/examples.hpp"

#include <algorithm>
#include <map>

namespace c3rt::cli {
namespace {

using Examples = std::map<std::string, std::vector<Example>>;

const Examples kExamples{
    {"",
     {{"c3rt run circle_slow --clock lockstep",
       "three circles in simulated time: report, pictures"},
      {"c3rt up circle_fast; c3rt status; c3rt down", "as a service in real time"},
      {"c3rt target hold", "another task for the service"},
      {"c3rt hz plan", "what is on the bus"},
      {"c3rt campaign circle_fast --seeds 1..20", "success rate and percentiles over the seeds"},
      {"c3rt solve problem.json --out result.json", "one C3 call on your own system"},
      {"c3rt reproduce table3", "our numbers beside the paper's"}}},
    {"run",
     {{"c3rt run circle_slow --clock lockstep", "three circles in simulated time"},
      {"c3rt run circle_slow --in-process", "the same samples in a tenth of the time"},
      {"c3rt run circle_vision --seed 7 --out out/v7", "in real time, with three cameras"},
      {"c3rt run circle_slow --set planner.c3.admm_iterations=2", ""},
      {"c3rt run cart_pole --set c3.projection=miqp", "a numerical example of the paper"}}},
    {"soak",
     {{"c3rt soak circle_service --duration 2h", "in real time, with the processes of a service"},
      {"c3rt soak circle_vision --in-process --duration 24h",
       "simulated, one seed after the other"},
      {"c3rt soak circle_slow --in-process --seed 17 --passes 1", "one of them again"}}},
    {"up",
     {{"c3rt up circle_slow", "returns once every process runs"},
      {"c3rt up circle_vision --domain 3 --out out/service", "a second one beside it"}}},
    {"serve",
     {{"c3rt serve circle_slow", "until Ctrl-C or SIGTERM"},
      {"c3rt serve circle_slow --domain 3 --dds lan", "under systemd or a container"}}},
    {"down", {{"c3rt down", "the instance on domain 0"}, {"c3rt down --domain 3", ""}}},
    {"status",
     {{"c3rt status", "the instance on domain 0"},
      {"c3rt status --domain 3 --dds lan", "that of another host, on the profile lan"}}},
    {"doctor",
     {{"c3rt doctor", "processes, DDS, rights, machine, folders, programs"},
      {"c3rt doctor --domain 3 --json | jq '.findings[] | select(.verdict != \"ok\")'", ""}}},
    {"latency",
     {{"c3rt latency", "a minute: is this machine good for 1 kHz?"},
      {"c3rt latency --load 2 --out out/loaded", "the same with two busy threads beside it"},
      {"c3rt latency circle_slow --duration 20", "without cameras, for a look"}}},
    {"recover", {{"c3rt recover", "after a reflex or c3rt stop"}, {"c3rt recover --domain 3", ""}}},
    {"stop", {{"c3rt stop", "the arm stands still"}, {"c3rt stop --domain 3", ""}}},
    {"fault",
     {{"c3rt fault push-object --impulse 0.005 0 0", ""},
      {"c3rt fault stall planner --for 0.5", ""},
      {"c3rt fault none vision", "ends its faults"}}},
    {"fault push-object",
     {{"c3rt fault push-object --impulse 0.005 0 0", "5 mNs along x"},
      {"c3rt fault push-object --impulse 0 -0.003 0 --object 1", ""}}},
    {"fault drop-commands",
     {{"c3rt fault drop-commands --for 0.005", "fewer than 20 in a row: rides through"},
      {"c3rt fault drop-commands --for 0.1", "a reflex; then c3rt recover"}}},
    {"fault freeze-camera",
     {{"c3rt fault freeze-camera --camera 1 --for 2", ""},
      {"c3rt fault freeze-camera", "camera 0 for a second"}}},
    {"fault lose-object",
     {{"c3rt fault lose-object --for 0.5", ""}, {"c3rt fault lose-object --domain 3", ""}}},
    {"fault stall",
     {{"c3rt fault stall planner --for 0.5", ""}, {"c3rt fault stall vision --for 1", ""}}},
    {"fault nan",
     {{"c3rt fault nan planner --for 0.1", ""}, {"c3rt fault nan impedance --for 0.01", ""}}},
    {"fault none", {{"c3rt fault none planner", ""}, {"c3rt fault none plant --domain 3", ""}}},
    {"target",
     {{"c3rt target circle --radius 0.08", ""},
      {"c3rt target pose 0.55 0.05", "brings the object there"},
      {"c3rt target hold", ""},
      {"c3rt target scenario", "back to the scenario's own"}}},
    {"target circle",
     {{"c3rt target circle --radius 0.08", ""},
      {"c3rt target circle --center 0.55 0 --radius 0.1 --lead-deg -20", "the other way round"}}},
    {"target path",
     {{"c3rt target path 0.5 -0.05 0.6 -0.05 0.6 0.05 0.5 0.05", "round a square, 2 s a side"},
      {"c3rt target path 0.5 -0.1 0.6 0.1 --interval 4 --held", ""}}},
    {"target line",
     {{"c3rt target line --x 0.55 --end -0.1", "towards -y"},
      {"c3rt target line --x 0.5 --step 0.03 --end 0.1", "towards +y"}}},
    {"target pose",
     {{"c3rt target pose 0.55 0.05", "x and y in metres, however it is turned"},
      {"c3rt target pose 0.5 -0.1 0.6 0.1 --hold 2", "two goals, one after the other"},
      {"c3rt target pose 0.6 0 --yaw-deg 0 --tolerance 0.02 --angle-tolerance-deg 10", "a box"}}},
    {"target task",
     {{"c3rt target task circle center_m=0.55,0 radius_m=0.08 lead_rad=0.35", ""},
      {"c3rt target task pose goals_m=0.5,-0.1 position_tolerance_m=0.02 hold_s=1", ""}}},
    {"target hold", {{"c3rt target hold", ""}, {"c3rt target hold --domain 3", ""}}},
    {"target scenario", {{"c3rt target scenario", ""}, {"c3rt target scenario --domain 3", ""}}},
    {"topics",
     {{"c3rt topics", ""},
      {"c3rt topics --peers", "whose every reader and writer is"},
      {"c3rt topics --domain 3 --dds lan", ""}}},
    {"echo",
     {{"c3rt echo object/estimate --count 3", ""},
      {"c3rt echo plan --timeout 0 | jq .phase", "waits until somebody writes"}}},
    {"hz",
     {{"c3rt hz plan", "a line a second until Ctrl-C"},
      {"c3rt hz service/status --count 5", "one line for each process"}}},
    {"campaign",
     {{"c3rt campaign circle_fast --seeds 1..20", "success rate and percentiles over the seeds"},
      {"c3rt campaign circle_fast --seeds 1..20 --in-process", "the same figures, sooner"},
      {"c3rt campaign circle_slow --seeds 1,5,9..12 --set planner.rate_hz=50 --out out/slow50", ""},
      {"c3rt campaign circle_fast --seeds 1..200 --engine dask --address tcp://host:8786", ""}}},
    {"reproduce",
     {{"c3rt reproduce table3", "the projections on the cart-pole, seconds"},
      {"c3rt reproduce table1 --miqp-limit 60", "with an hour's patience for the MIQP"},
      {"c3rt reproduce fig5 --out out/figures", ""},
      {"c3rt reproduce comparison --seeds 1..20", "every projection on the same circle"},
      {"c3rt reproduce push_anything --seeds 1..50", "objects from anywhere to a goal pose"}}},
    {"plan",
     {{"c3rt plan push_t < scenes.jsonl > plans.jsonl", "a JSON object a line: docs/clients.md"},
      {"c3rt plan mine.yaml --set planner.sampling.seed=2", "a scenario of your own"}}},
    {"scenario",
     {{"c3rt scenario", "the names of all"},
      {"c3rt scenario circle_fast", "whole, with what it extends"},
      {"c3rt scenario circle_fast --set planner.rate_hz=75 > mine.yaml", "a copy for yourself"}}},
    {"solve",
     {{"c3rt solve problem.json --out result.json", ""},
      {"c3rt solve problem.json | jq .u", "the result on standard output"}}},
    {"object",
     {{"c3rt object add part.stl --mass 0.3 --scale 0.001", "part.xml and its mesh"},
      {"c3rt lcs inspect part.xml", "what a planner sees of it"}}},
    {"object add",
     {{"c3rt object add part.stl --mass 0.3 --scale 0.001", "a file in millimetres"},
      {"c3rt object add l.obj --mass 0.4 --friction 0.5 --out objects", ""},
      {"c3rt object add l.obj --mass 0.4 --decompose --tags 100",
       "convex pieces by CoACD, AprilTags on top"},
      {"c3rt object add l.obj --mass 0.4 --name bracket --force", "overwrites bracket.xml"}}},
    {"lcs",
     {{"c3rt lcs inspect t.xml", "what a planner sees of an object of your own"},
      {"c3rt lcs inspect t.xml --out problem.json", "then c3rt solve problem.json"}}},
    {"lcs inspect",
     {{"c3rt lcs inspect t.xml", "bodies, contacts, sizes, conditioning, errors"},
      {"c3rt lcs inspect t.xml box.xml --support-points 3", "two objects"},
      {"c3rt lcs inspect t.xml --pairs object_table --contact-model stewart_trinkle", ""},
      {"c3rt lcs inspect t.xml --out problem.json", "then c3rt solve problem.json"},
      {"c3rt lcs inspect pusher.xml --pairs fork,disc,friction=0.3 disc,world",
       "a mechanism with motors, contacts by bodies or geoms"}}},
    {"bench",
     {{"c3rt bench c3 --filter solve/1_ball", ""},
      {"c3rt bench vision --repetitions 9 --json vision.json", ""}}},
};

constexpr std::size_t kColumn = 48;

}  // namespace

const std::vector<Example>& examples_of(const std::string& command) {
  return kExamples.at(command);
}

std::string examples_text(const std::string& command) {
  std::string text = "Examples:";
  for (const Example& example : examples_of(command)) {
    text += "\n  " + example.line;
    if (example.what.empty()) continue;
    const std::size_t length = example.line.size();
    text += std::string(length < kColumn ? kColumn - length : 2, ' ') + example.what;
  }
  return text;
}

}  // namespace c3rt::cli
