#!/usr/bin/env bash
# The property tests with many more random instances than the test suite has time for.
#
#   tests/properties.sh [INSTANCES]        default: 10000 of each kind; build first: ./c3rt build
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
instances=${1:-10000}
[[ $instances =~ ^[1-9][0-9]*$ ]] || { echo "usage: tests/properties.sh [INSTANCES]" >&2; exit 2; }
[[ -f $root/build/release/CTestTestfile.cmake ]] || { echo "tests/properties.sh: nothing is built: run ./c3rt build first" >&2; exit 2; }
# ten thousand instances take longer than a test may
C3RT_PROPERTY_INSTANCES=$instances exec ctest --test-dir "$root/build/release" --label-regex property --timeout 36000 \
  --output-on-failure --parallel "$(nproc)"
