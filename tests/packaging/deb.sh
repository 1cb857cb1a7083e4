#!/bin/bash
# The Debian packages from their making to their end, in a bare Debian 12 of their own: made by CPack, installed with what
# they depend on, a lockstep scenario run by the services' user, upgraded, removed and purged; nothing may be left.
#   tests/packaging/deb.sh [FOLDER]     FOLDER keeps the bare root for the next call, which is then a minute shorter
# Needs root, the network (Debian's archive) and a release build. Exit status: 0 all is well, 1 something is not, 2 it cannot
# be tried here.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
build=$root/build/release
say() { printf '\n-- %s\n' "$*"; }
fail() { printf 'deb.sh: FAILED: %s\n' "$*" >&2; exit 1; }
cannot() { printf 'deb.sh: %s\n' "$*" >&2; exit 2; }

make_packages() {
  (cd "$work" && cpack -G DEB --config "$build/CPackConfig.cmake" -B "$work/packages" > cpack.log 2>&1) ||
    { tail -20 "$work/cpack.log"; fail "cpack"; }
  for package in "$work"/packages/*.deb; do
    dpkg-deb --info "$package" | sed -n 's/^ \(Package\|Version\|Installed-Size\|Depends\|Recommends\)/\1/p'
  done
}

make_bare_root() {
  [ ! -e "$bare/etc/debian_version" ] || return 0
  local bootstrap=debootstrap
  if ! command -v debootstrap > /dev/null; then
    (cd "$work" && apt-get -q download debootstrap > apt.log 2>&1) || cannot "debootstrap cannot be had: $(tail -1 "$work/apt.log")"
    dpkg-deb -x "$work"/debootstrap_*.deb "$work/debootstrap"
    export DEBOOTSTRAP_DIR="$work/debootstrap/usr/share/debootstrap"
    bootstrap="$work/debootstrap/usr/sbin/debootstrap"
  fi
  mkdir -p "$bare"
  "$bootstrap" --variant=minbase --include=systemd,ca-certificates bookworm "$bare" > "$work/debootstrap.log" 2>&1 ||
    cannot "debootstrap: $(tail -3 "$work/debootstrap.log")"
}

# in the bare root, with an environment of its own
inside() {
  chroot "$bare" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C DEBIAN_FRONTEND=noninteractive \
    ${http_proxy:+"http_proxy=$http_proxy"} ${https_proxy:+"https_proxy=$https_proxy"} "$@"
}
quietly() { inside "$@" > "$work/log" 2>&1 || { tail -20 "$work/log"; return 1; }; }
# the same as the user of the services, in a network of its own
as_service() {
  unshare --net bash -c 'ip link set lo up; exec "$@"' - chroot "$bare" /usr/sbin/runuser -u c3rt -- /usr/bin/env -i \
    PATH=/usr/bin:/bin HOME=/tmp XDG_RUNTIME_DIR=/tmp/run C3RT_KEYS=/var/lib/c3rt/keys "$@"
}
# Becomes the first process of a machine of its own, which is systemd; in namespaces of its own
machine() {
  ip link set lo up
  # a root that services can have their own view of is a mount
  mount --bind "$bare" "$bare"
  mount -t proc proc "$bare/proc"
  mount -t sysfs -o ro sysfs "$bare/sys"
  mount -t tmpfs -o mode=755 tmpfs "$bare/run"
  mount -t tmpfs -o mode=1777 tmpfs "$bare/tmp"
  mount -t tmpfs -o mode=755 tmpfs "$bare/dev"
  mkdir "$bare/dev/pts" "$bare/dev/shm"
  mount -t devpts -o newinstance,ptmxmode=0666 devpts "$bare/dev/pts"
  ln -s pts/ptmx "$bare/dev/ptmx"
  ln -s /proc/self/fd "$bare/dev/fd"
  local device
  for device in null zero full random urandom tty; do
    touch "$bare/dev/$device"
    mount --bind "/dev/$device" "$bare/dev/$device"
  done
  if [ -e /sys/fs/cgroup/cgroup.controllers ]; then
    mount -t cgroup2 cgroup2 "$bare/sys/fs/cgroup"
  else
    mount -t tmpfs -o mode=755 tmpfs "$bare/sys/fs/cgroup"
    mkdir "$bare/sys/fs/cgroup/systemd" "$bare/sys/fs/cgroup/unified"
    mount -t cgroup -o none,name=systemd cgroup "$bare/sys/fs/cgroup/systemd"
    mount -t cgroup2 cgroup2 "$bare/sys/fs/cgroup/unified"
  fi
  cd "$bare"
  pivot_root . mnt
  umount --lazy /mnt
  mount --make-rshared /
  exec /usr/bin/env -i container=c3rt PATH=/usr/sbin:/usr/bin:/sbin:/bin /lib/systemd/systemd --unit=multi-user.target
}
in_machine() {
  nsenter --target "$first" --all --root --wd /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C "$@"
}
# until SECONDS WORDS COMMAND...: repeats it until it succeeds
until_so() {
  local -r end=$((SECONDS + $1)) what=$2
  shift 2
  until "$@" > "$work/log" 2>&1; do
    ((SECONDS < end)) || { tail -20 "$work/log"; in_machine journalctl --no-pager -n 30 -u 'c3rt-*' || true; fail "$what"; }
    sleep 0.1
  done
}
pid_of() { in_machine systemctl show --value -p MainPID "c3rt-$1"; }
moves() { in_machine c3rt status > "$work/status" && grep -q "follows commands" "$work/status" && grep -q "tracks the plan" "$work/status"; }
has_ended() { [ "$(pid_of "$1")" = 0 ]; }
is_another() { local -r pid=$(pid_of "$1"); [ "$pid" != 0 ] && [ "$pid" != "$2" ]; }

# the services as systemd runs them: their rights, what a death of each does, and their end
booted() {
  unshare --pid --fork --mount --propagation private --net --uts --ipc --cgroup "$0" --machine "$bare" > "$work/boot.log" 2>&1 &
  local -r booting=$!
  until_so 10 "process 1" pgrep --parent "$booting"
  first=$(pgrep --parent "$booting")
  trap 'kill -9 "$first" 2> /dev/null || true' EXIT
  until_so 60 "systemd" in_machine systemctl is-active multi-user.target
  in_machine systemctl start c3rt.target || fail "systemctl start c3rt.target"
  until_so 30 "the robot does not move" moves
  cat "$work/status"

  local name before begin priority limits=true
  prlimit --rtprio=1:1 true 2> /dev/null || limits=false
  for name in plant impedance planner vision; do
    before=$(pid_of "$name")
    in_machine cat "/proc/$before/status" > "$work/rights"
    [ "$(awk '/^Uid:/ {print $2}' "$work/rights")" = "$(in_machine id -u c3rt)" ] || fail "c3rt-$name is not the user c3rt"
    grep -q "^CapEff:.0*$" "$work/rights" && grep -q "^CapBnd:.0*$" "$work/rights" || fail "c3rt-$name has a capability"
    grep -q "^NoNewPrivs:.1$" "$work/rights" || fail "c3rt-$name may get new privileges"
    priority=$(in_machine chrt --all-tasks --pid "$before" | awk '/priority/ && $NF > top {top = $NF} END {print top + 0}')
    if "$limits"; then
      [ "$(in_machine awk '/^Max realtime priority/ {print $4}' "/proc/$before/limits")" = "$priority" ] ||
        fail "the highest thread of c3rt-$name has priority $priority, which is not all that its unit allows"
    fi
    echo "c3rt-$name: user c3rt, no capability, SCHED_FIFO up to $priority"
  done
  "$limits" || echo "this machine lets nobody raise a limit (CAP_SYS_RESOURCE): what the units allow was not looked at"
  for name in vision planner impedance plant; do
    before=$(pid_of "$name") begin=$(date +%s.%N)
    in_machine systemctl kill --signal KILL --kill-who main "c3rt-$name"
    until_so 5 "c3rt-$name is not started again" is_another "$name" "$before"
    until_so 10 "the robot does not move after the death of c3rt-$name" moves
    echo "kill -9 of c3rt-$name: the robot moves, and all four say so, $(date +%s.%N | awk -v begin="$begin" '{printf "%.1f", $1 - begin}') s later"
  done
  in_machine systemctl stop c3rt.target
  for name in vision planner impedance plant; do
    until_so 10 "c3rt-$name has not ended with the target" has_ended "$name"
    if in_machine systemctl is-failed --quiet "c3rt-$name"; then fail "c3rt-$name ended with a failure"; fi
  done
  kill -9 "$first"
}

# every file and folder on the disk (/run is not) but what apt and dpkg keep of all packages, and who is known
picture() {
  (cd "$bare" && find . -xdev \( -path ./proc -o -path ./run -o -path ./tmp -o -path ./packages -o -path ./var/cache -o -path ./var/lib/apt \
    -o -path ./var/log -o -path ./var/lib/dpkg -o -path './etc/*-' \) -prune -o -print | sort)
  cut -d: -f1 "$bare/etc/passwd" "$bare/etc/group"
}
files_of() { basename -a "$work"/"$1"/*.deb | sed 's|^|/packages/|'; }

# mounts of this part are seen by nobody else, and end with it
live() {
  mount -t proc proc "$bare/proc"
  cp /etc/resolv.conf "$bare/etc/resolv.conf"
  rm -rf "$bare/packages" "$bare"/tmp/* && mkdir -m 1777 "$bare/tmp/run" && mkdir "$bare/packages"
  cp "$work"/packages/*.deb "$work"/next/*.deb "$bare/packages"
  runtime=$(echo "$work"/packages/c3rt_*.deb) development=$(echo "$work"/packages/c3rt-dev_*.deb)

  say "what they depend on, from Debian 12"
  quietly apt-get -q update || cannot "the archive cannot be reached"
  quietly apt-get -qy satisfy --no-install-recommends \
    "$(dpkg-deb --field "$runtime" Depends), $(dpkg-deb --field "$development" Depends)" || fail "Debian 12 cannot satisfy them"
  quietly apt-get -qy install --no-install-recommends lintian || fail "lintian cannot be had"
  # there is no address to write to
  inside lintian --allow-root --fail-on error --suppress-tags bogus-mail-host $(files_of packages) || fail "lintian"
  picture > "$work/before"

  say "installed"
  quietly dpkg --install $(files_of packages) || fail "dpkg --install"
  inside c3rt --version
  for program in "$bare"/usr/bin/c3rt*; do
    [ -x "$program" ] || continue
    if inside ldd "${program#"$bare"}" | grep "not found"; then fail "$program lacks a library"; fi
  done
  inside systemd-analyze verify c3rt.target c3rt-plant.service c3rt-impedance.service c3rt-planner.service \
    c3rt-vision.service || fail "the units"
  [ ! -e "$bare/etc/systemd/system/multi-user.target.wants/c3rt.target" ] || fail "the robot would move by itself"
  cmake -S "$root/tests/package" -B "$work/consumer" -DCMAKE_PREFIX_PATH="$bare/usr" > "$work/log" 2>&1 ||
    { tail "$work/log"; fail "find_package(c3rt) in c3rt-dev"; }

  say "a lockstep scenario by the services' user, plain and with keys"
  as_service c3rt run circle_slow --clock lockstep --no-pictures --out /tmp/plain || fail "c3rt run"
  # too short for its criteria
  as_service c3rt campaign cart_pole --seeds 1..2 --duration 0.2 --out /tmp/campaign || [ $? = 1 ] || fail "c3rt campaign"
  [ -e "$bare/tmp/campaign/campaign.json" ] || fail "c3rt campaign leaves no table"
  as_service c3rt keys init --out /var/lib/c3rt/keys || fail "c3rt keys init"
  as_service c3rt run circle_slow --clock lockstep --no-pictures --profile secure --out /tmp/secure || fail "c3rt run, secure"

  say "booted"
  booted

  say "upgraded"
  echo "C3RT_DOMAIN=7" >> "$bare/etc/c3rt/service.conf"
  quietly dpkg --install $(files_of next) || fail "the upgrade"
  [ "$(inside dpkg-query -W -f '${Version}' c3rt)" = "$next_version" ] || fail "the version after the upgrade"
  grep -q C3RT_DOMAIN=7 "$bare/etc/c3rt/service.conf" || fail "the upgrade forgot what was configured"
  as_service c3rt keys check || fail "the upgrade forgot the keys"

  say "removed, then purged"
  quietly dpkg --remove c3rt c3rt-dev || fail "the removal"
  [ -e "$bare/etc/c3rt/service.conf" ] || fail "what was configured does not outlive the removal"
  [ -e "$bare/var/lib/c3rt/keys/ca.key" ] || fail "the keys do not outlive the removal"
  [ ! -e "$bare/usr/share/c3rt" ] && [ ! -e "$bare/usr/bin/c3rt" ] || fail "the removal leaves files"
  quietly dpkg --purge c3rt c3rt-dev || fail "the purge"
  picture > "$work/after"
  diff "$work/before" "$work/after" || fail "something is left (> after, < before)"
  echo "nothing is left"
}

if [ "${1:-}" = --machine ]; then
  bare=$2
  machine
fi
if [ "${1:-}" = --live ]; then
  work=$2 bare=$3 next_version=$4
  live
  exit
fi

[ "$(id -u)" = 0 ] || cannot "needs root, for a root file system"
[ -x "$build/bin/c3rt" ] || cannot "build first: ./c3rt build"
work=$(mktemp -d)
trap 'rm -rf --one-file-system "$work"' EXIT
bare=$(realpath -m "${1:-$work}")/root
say "the packages"
make_packages
# the next version: the same files under a higher number
mkdir "$work/next"
for package in "$work"/packages/*.deb; do
  dpkg-deb -R "$package" "$work/unpacked"
  next_version=$(dpkg-deb --field "$package" Version).next
  sed -i "s/^Version: .*/Version: $next_version/" "$work/unpacked/DEBIAN/control"
  dpkg-deb -b "$work/unpacked" "$work/next/$(basename "$package" .deb).next.deb" > /dev/null
  rm -rf "$work/unpacked"
done
say "a bare Debian 12"
make_bare_root
# not exec: what is mounted there is gone before the folder is removed
unshare --mount --propagation private "$0" --live "$work" "$bare" "$next_version"
