#!/bin/bash
# The circle with its processes on two hosts: network namespaces joined by a veth pair, the profile lan, and packets lost.
#   tests/two_hosts.sh [LOSS_PER_MILLE [SCENARIO [PROCESSES_THERE [MORE OPTIONS OF c3rt run…]]]]
#   tests/two_hosts.sh 50 circle_vision planner,vision
# On the first host: the command, plant and impedance; on the second: the processes named (planner,vision). Each host loses that
# many of its packets as it sends them, by Cyclone's own setting, so that it works without the kernel's netem. Needs root.
# Exit status: that of c3rt run.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
bin=${C3RT_BIN:-$root/build/release/bin}
loss=${1:-50} scenario=${2:-circle_vision} there=${3:-planner,vision}
shift $(($# < 3 ? $# : 3))
[ "$(id -u)" = 0 ] || { echo "two_hosts.sh: needs root, for network namespaces" >&2; exit 2; }
[ -x "$bin/c3rt" ] || { echo "two_hosts.sh: there is no $bin/c3rt; build first, or say where it is by C3RT_BIN" >&2; exit 2; }

work=$(mktemp -d)
holders=
trap 'kill $holders 2>/dev/null || true; rm -rf "$work"' EXIT
# a host is a process that only holds its namespace
start_host() {
  unshare --net sleep infinity &
  host=$!
  holders="$holders $host"
  while [ "$(readlink "/proc/$host/ns/net")" = "$(readlink /proc/self/ns/net)" ]; do sleep 0.05; done
}
start_host && first=$host
start_host && second=$host
on() { nsenter --net="/proc/$1/ns/net" "${@:2}"; }
on "$first" ip link add veth0 type veth peer name veth0 netns "$second"
number=1
for host in $first $second; do
  on "$host" ip address add "10.99.0.$number/24" dev veth0
  on "$host" ip link set lo up
  on "$host" ip link set veth0 up
  number=$((number + 1))
done

# the profile lan, on this wire, with losses
sed -e 's|autodetermine="true"|name="veth0"|' \
    -e "s|</Internal>|  <Test><XmitLossiness>$loss</XmitLossiness></Test>\n    </Internal>|" \
    "$root/config/dds/lan.xml" > "$work/lan_with_losses.xml"

# c3rt starts all four from here, and some of them go over to the second host at once
mkdir "$work/bin" "$work/run"
for process in plant impedance planner vision; do
  case ",$there," in
    *",$process,"*)
      printf '#!/bin/sh\nexec nsenter --net=/proc/%s/ns/net %s "$@"\n' "$second" "$bin/c3rt-$process" > "$work/bin/c3rt-$process"
      chmod +x "$work/bin/c3rt-$process" ;;
    *) ln -s "$bin/c3rt-$process" "$work/bin/c3rt-$process" ;;
  esac
done
export C3RT_PROCESS_DIRECTORY="$work/bin" XDG_RUNTIME_DIR="$work/run"
status=0
on "$first" "$bin/c3rt" run "$scenario" --profile "$work/lan_with_losses.xml" --out "${C3RT_OUT:-out/two_hosts}" "$@" || status=$?
for host in $first $second; do
  on "$host" cat /proc/net/dev | awk -v host="$host" '/veth0/ {print "packets received at a host: " $3 ", sent: " $11}'
done
exit $status
