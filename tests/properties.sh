#!/usr/bin/env bash
# The property tests with many more random instances than the test suite has time for.
#
#   tests/properties.sh [INSTANCES]        default: 10000 of each kind; build first: ./c3rt build
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
instances=${1:-10000}
[[ $instances =~ ^[1-9][0-9]*$ ]] || { echo "usage: tests/properties.sh [INSTANCES]" >&2; exit 2; }
[[ -f $root/build/release/CTestTestfile.cmake ]] || { echo "tests/properties.sh: nothing is built: run ./c3rt build first" >&2; exit 2; }
mapfile -t programs < <(ctest --test-dir "$root/build/release" --show-only --verbose --label-regex property |
  sed -n 's/^.*Test command: "\{0,1\}\([^"]*\)"\{0,1\}$/\1/p')
((${#programs[@]})) || { echo "tests/properties.sh: no property test is built: run ./c3rt build first" >&2; exit 2; }
# not by ctest: so many instances take longer than a test may
export C3RT_PROPERTY_INSTANCES=$instances
failed=0
for program in "${programs[@]}"; do
  printf '%s, %s instances\n' "$(basename "$program")" "$instances"
  "$program" || failed=1
done
exit "$failed"
