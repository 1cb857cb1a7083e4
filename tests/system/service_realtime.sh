#!/usr/bin/env bash
# Start orders, stop and recovery, stalls and restarts of the four processes in real time: the robot shall never end in
# a reflex, and shall move again afterwards. Not part of the test suite, whose verdicts do not depend on the machine.
#
#   tests/system/service_realtime.sh [TIMES] [SCENARIO] [KINDS]      default: 20 circle_slow, all kinds
#
# KINDS is a regular expression on the names of the kinds: late, stop, stall_planner, stall_vision, stall_impedance,
# stall_plant, nan_plant, restart_planner, restart_vision, restart_impedance. After an event that went wrong comes what
# the processes said during it. Uses DDS domain 77 of this host; best in a network namespace of its own.
set -uo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
times=${1:-20}
scenario=$root/config/scenarios/${2:-circle_slow}.yaml
kinds=${3:-.}
bin=${C3RT_PROCESS_DIRECTORY:-$root/build/release/bin}
domain=77
[[ $times =~ ^[1-9][0-9]*$ && -f $scenario ]] ||
  { echo "usage: tests/system/service_realtime.sh [TIMES] [SCENARIO] [KINDS]" >&2; exit 2; }
[[ -x $bin/c3rt ]] || { echo "service_realtime.sh: nothing is built: run ./c3rt build first" >&2; exit 2; }
logs=$(mktemp -d)
declare -A pids=()
declare -A seen=()  # lines of a log before the event

start() {  # PROCESS
  "$bin/c3rt-$1" "$scenario" --domain $domain --dds-profile "$root/config/dds/loopback.xml" \
    --set plant.rolling_friction_m=0.001 >>"$logs/$1.log" 2>&1 &
  pids[$1]=$!
}
end_all() {
  for process in "${!pids[@]}"; do kill -KILL "${pids[$process]}" 2>/dev/null; wait "${pids[$process]}" 2>/dev/null; done
  pids=()
}
trap 'end_all; rm -rf "$logs"' EXIT
say() { "$bin/c3rt" "$@" --domain $domain >>"$logs/client.log" 2>&1; }
mode() { grep -a 'mode ' "$logs/plant.log" | tail -1; }
# of the robot's own limits; commands that were missing are no fault of the servo's
reflexes() { grep -ac 'mode reflex: .*\(joint\|instability\)' "$logs/plant.log"; }

failed=0
verdict() {  # NAME GOOD OF
  printf '%-46s %2d of %2d\n' "$1" "$2" "$3"
  (($2 == $3)) || failed=1
}
begin() {
  for log in plant impedance planner vision client; do
    touch "$logs/$log.log"
    seen[$log]=$(wc -l <"$logs/$log.log")
  done
  before=$(reflexes)
}
went_well() {  # has the event neither caused a reflex nor left the robot at rest?
  if [[ $(mode) == *"follows commands"* && $(reflexes) == "$before" ]]; then return 0; fi
  went_wrong
}
went_wrong() {
  for log in plant impedance planner vision client; do
    tail -n "+$((seen[$log] + 1))" "$logs/$log.log" | sed "s/^/    $log: /"
  done
  return 1
}
all_up() {
  : >"$logs/plant.log"
  for process in plant planner vision impedance; do start $process; done
  sleep 2.5
}

if [[ late =~ $kinds ]]; then
  good=0
  for ((i = 0; i < times; ++i)); do
    : >"$logs/plant.log"
    begin
    order=(plant planner vision impedance)
    late=${order[$((i % 4))]}
    for process in "${order[@]}"; do [[ $process == "$late" ]] || start "$process"; done
    sleep "$(awk -v i="$i" -v n="$times" 'BEGIN {print 0.1 + 4.9 * (i / n) ^ 2}')"
    start "$late"
    sleep 3
    went_well && good=$((good + 1))
    end_all
  done
  verdict "a process that starts 0.1 to 5 s late" "$good" "$times"
fi

all_up
if [[ stop =~ $kinds ]]; then
  good=0
  for ((i = 0; i < times; ++i)); do
    begin
    if say stop && say recover; then
      sleep 0.5
      went_well && good=$((good + 1))
    else
      went_wrong
    fi
  done
  verdict "stop and recover" "$good" "$times"
fi

for fault in "planner 2" "vision 1" "impedance 0.3" "plant 0.3"; do
  set -- $fault
  [[ stall_$1 =~ $kinds ]] || continue
  good=0
  for ((i = 0; i < times; ++i)); do
    begin
    say fault stall "$1" --for "$2"
    sleep "$(awk -v s="$2" 'BEGIN {print s + 1}')"
    went_well && good=$((good + 1))
  done
  verdict "a stall of $1 for $2 s" "$good" "$times"
done

if [[ nan_plant =~ $kinds ]]; then
  good=0
  for ((i = 0; i < times; ++i)); do
    begin
    if say fault nan plant --for 0.05 && sleep 0.5 && say recover; then
      went_well && good=$((good + 1))
    else
      went_wrong
    fi
  done
  verdict "states that are not finite for 0.05 s, recover" "$good" "$times"
fi

for process in planner vision impedance; do
  [[ restart_$process =~ $kinds ]] || continue
  good=0
  for ((i = 0; i < times; ++i)); do
    begin
    kill -KILL "${pids[$process]}" && wait "${pids[$process]}" 2>/dev/null
    ((i % 2)) && sleep 0.5
    start $process
    sleep 3
    went_well && good=$((good + 1))
  done
  verdict "$process killed and started again" "$good" "$times"
done
exit $failed
