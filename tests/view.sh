#!/usr/bin/env bash
# The page of `c3rt view` in a browser: beside up, run and replay, with the cameras' pictures (tests/view/view_test.py). In a
# network of its own and a folder that is gone afterwards: needs root, Chromium and its driver (Debian: chromium,
# chromium-driver), and the network for packages of Python.
#
#   tests/view.sh                  the tests
#   tests/view.sh --load [TURNS]   what the page takes from a run in real time, TURNS times each way, interleaved (default: 5)
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
build=${C3RT_BUILD:-$root/build/release}
[[ $(id -u) == 0 ]] || { printf 'c3rt: error: needs root, for a network of its own\n' >&2; exit 2; }
for program in "$build/bin/c3rt" chromium chromedriver; do
  command -v "$program" >/dev/null || { printf 'c3rt: error: there is no %s\n' "$program" >&2; exit 2; }
done
words=(-m pytest -q -p no:cacheprovider "$root/tests/view/view_test.py")
if [[ ${1:-} == --load ]]; then
  words=("$root/tests/view/load.py" "${2:-5}")
elif [[ $# != 0 ]]; then
  printf 'usage: %s [--load [TURNS]]\n' "$0" >&2
  exit 2
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python=${C3RT_VIEW_PYTHON:-$work/python}
if [[ ! -x $python/bin/python ]]; then
  python3 -m venv "$python"
  "$python/bin/pip" --quiet --disable-pip-version-check install cyclonedds==11.0.1 'viser>=1.1,<2' pytest==9.2.0 'selenium>=4.20,<5'
fi
mkdir "$work/runtime" "$work/tmp"
export C3RT_PROGRAM=$build/bin/c3rt C3RT_PYTHON=$python/bin/python PYTHONPATH=$build/python PYTHONDONTWRITEBYTECODE=1
export XDG_RUNTIME_DIR=$work/runtime TMPDIR=$work/tmp
unshare -n bash -c 'ip link set lo up; ip link set lo multicast on; exec "$@"' - "$C3RT_PYTHON" "${words[@]}"
