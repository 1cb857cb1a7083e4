#!/usr/bin/env bash
# The matrix of clients of docs/clients.md: each reads robot/state and plan of `c3rt up circle_slow`, gives it a circle and awaits the
# answer, with the profiles loopback, lan and secure. In a network of its own and a folder that is gone afterwards: needs
# root, idlc and Cyclone DDS's headers (Debian: cyclonedds-tools, cyclonedds-dev), cargo, and the network for packages of Python and Rust.
#
#   tests/clients.sh [CLIENT…]     python11 python10 c c++ rust; without a word all of them
#
# Exit status: 0 where each did all of it in each profile that docs/clients.md has it in.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
bin=${C3RT_BIN:-$root/build/release/bin}
[[ $# != 0 ]] || set -- python11 python10 c c++ rust
clients=("$@")
for client in "${clients[@]}"; do
  case $client in
    python11 | python10 | c | c++ | rust) ;;
    *) printf 'usage: %s [python11|python10|c|c++|rust …]\n' "$0" >&2; exit 2 ;;
  esac
done
[[ $(id -u) == 0 ]] || { printf 'c3rt: error: needs root, for a network of its own\n' >&2; exit 2; }
[[ -x $bin/c3rt ]] || { printf 'c3rt: error: there is no %s/c3rt; build first, or say where it is by C3RT_BIN\n' "$bin" >&2; exit 2; }

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# ---- made ready with the network

says() { printf '%s\n' "$*" >&2; }
python_with() {  # folder, version of cyclonedds
  python3 -m venv "$work/$1"
  "$work/$1/bin/pip" --quiet --disable-pip-version-check install "cyclonedds==$2" "${@:3}"
}
for client in "${clients[@]}"; do
  says "making $client"
  case $client in
    python11) python_with python11 11.0.1 ;;
    python10)  # of which PyPI has the source: on the system's Cyclone DDS
      mkdir "$work/cyclone"
      ln -s "/usr/lib/$(uname -m)-linux-gnu" "$work/cyclone/lib" && ln -s /usr/include /usr/bin "$work/cyclone"
      CYCLONEDDS_HOME=$work/cyclone python_with python10 0.10.2 --no-binary cyclonedds ;;
    c | c++)
      mkdir -p "$work/c" && (cd "$work/c" && idlc -l c "$root/idl/c3rt.idl" && cc -O1 -c c3rt.c)
      if [[ $client == c ]]; then compile=(cc); else compile=(c++ -x c++); fi
      "${compile[@]}" -O1 -I"$work/c" -c "$root/tests/clients/client.c" -o "$work/$client.o"
      cc "$work/$client.o" "$work/c/c3rt.o" -lddsc -o "$work/$client.client" ;;
    rust)
      cp -r "$root/tests/clients/rust" "$work/rust"
      cargo build --quiet --release --manifest-path "$work/rust/Cargo.toml" ;;
  esac
done
python3 "$root/idl/generate.py" python "$root/idl/c3rt.idl" "$work/types"
export XDG_CONFIG_HOME=$work/config XDG_RUNTIME_DIR=$work/run
mkdir -p "$XDG_RUNTIME_DIR"
"$bin/c3rt" keys init >/dev/null
# the client's keys by the names that ROS 2 has for them, and rustdds with it
mkdir "$work/rust_keys"
keys=$XDG_CONFIG_HOME/c3rt/keys
for name in identity_ca.cert.pem=ca.crt permissions_ca.cert.pem=ca.crt governance.p7s=governance.p7s cert.pem=client/identity.crt \
  key.pem=client/identity.key permissions.p7s=client/permissions.p7s; do
  ln -s "$keys/${name#*=}" "$work/rust_keys/${name%%=*}"
done

# ---- run

cat >"$work/run.sh" <<'RUN'
set -u
root=$1 bin=$2 work=$3
shift 3
ip link set lo up
ip link add veth0 type veth peer name veth1
ip address add 10.99.0.1/24 dev veth0
ip link set veth0 up && ip link set veth1 up
ip route add 224.0.0.0/4 dev veth0
export C3RT_KEYS=$XDG_CONFIG_HOME/c3rt/keys C3RT_IDENTITY=client
export C3RT_DDS_SECURITY=/usr/lib/$(uname -m)-linux-gnu/libddsc0debian
failed=0
for profile in loopback lan secure; do
  "$bin/c3rt" up circle_slow --profile $profile --out "$work/out-$profile" >"$work/up.log" 2>&1 || { cat "$work/up.log"; exit 1; }
  for client in "$@"; do
    words=(0)
    case $client in
      python*) command=("$work/$client/bin/python" "$root/tests/clients/client.py") ;;
      rust) command=("${CARGO_TARGET_DIR:-$work/rust/target}/release/client") ;;  # it reads no profile
      *) command=("$work/$client.client") ;;
    esac
    [[ $client-$profile != rust-secure ]] || words=(0 "$work/rust_keys")
    said=$(cd "$work" && PYTHONPATH=$work/types CYCLONEDDS_URI=file://$root/config/dds/$profile.xml timeout 60 "${command[@]}" "${words[@]}" 2>"$work/error") && ok=yes || ok=no
    [[ $ok == yes ]] || said=${said:-$(tail -n 1 "$work/error")}
    printf '%-9s %-9s %-3s %s\n' "$client" "$profile" "$ok" "$said"
    # PyPI's wheel has no security plugins; rustdds refuses Cyclone's handshake
    case $client-$profile in
      python11-secure | rust-secure) ;;
      *) [[ $ok == yes ]] || failed=1 ;;
    esac
  done
  "$bin/c3rt" down >/dev/null 2>&1 || true
done
exit $failed
RUN
unshare --net bash "$work/run.sh" "$root" "$bin" "$work" "${clients[@]}"
