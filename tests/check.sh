#!/usr/bin/env bash
# What a reviewer should not have to look for. Beside the test suite, and like it part of continuous integration.
#
#   tests/check.sh                     format, then tidy, then sanitizers
#   tests/check.sh format              the sources are as .clang-format has them; --fix makes them so
#   tests/check.sh tidy [FILE...]      clang-tidy's checks of .clang-tidy, of these files or of all
#   tests/check.sh sanitizers          the unit and property tests under address and undefined-behaviour sanitizers
#
# Needs cmake/packages_check.txt (./c3rt check installs it) and, for tidy, a configured build (./c3rt build).
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
jobs=${C3RT_JOBS:-$(nproc)}
cd "$root"

fail() {
  printf 'check: %s\n' "$*" >&2
  exit 1
}
usage() {
  sed -n 's/^# \{0,1\}//; 2,10p' "${BASH_SOURCE[0]}"
  exit "$1"
}
# need PROGRAM: of a fixed major version, since another one formats otherwise
need() {
  command -v "$1" >/dev/null || fail "$1 is missing: run ./c3rt check, or install what cmake/packages_check.txt lists"
  [[ $("$1" --version) == *"version 14."* ]] || fail "$1 is not of version 14: $("$1" --version | head -n 1)"
}
sources() { git ls-files -- '*.cpp' '*.hpp'; }

format() {
  need clang-format
  if [[ ${1:-} == --fix ]]; then
    sources | xargs -r clang-format -i
    return
  fi
  local -a wrong
  mapfile -t wrong < <(sources | xargs -r clang-format --dry-run 2>&1 | sed -n 's/^\([^:]*\):.*code should be clang-formatted.*/\1/p' | sort -u)
  ((${#wrong[@]} == 0)) || fail "not as .clang-format has it (tests/check.sh format --fix): ${wrong[*]}"
  printf 'check: format: %s files\n' "$(sources | wc -l)"
}

tidy() {
  need clang-tidy
  [[ -f build/release/compile_commands.json ]] || fail "no build/release/compile_commands.json: run ./c3rt build first"
  local -a files
  if (($#)); then files=("$@"); else mapfile -t files < <(git ls-files -- '*.cpp' ':!tests'); fi
  printf 'check: tidy: %s files\n' "${#files[@]}"
  printf '%s\0' "${files[@]}" |
    xargs -0 -n 4 -P "$jobs" clang-tidy -p build/release --quiet --warnings-as-errors='*' 2>/dev/null ||
    fail "clang-tidy has something to say: see above"
}

sanitizers() {
  cmake --preset asan >/dev/null
  ninja -C build/asan -j "$jobs" --quiet unit_tests || fail "the sanitized tests do not build"
  ctest --test-dir build/asan --output-on-failure --parallel 2 --label-regex '^(unit|property)$' ||
    fail "a sanitized test failed: see above"
}

case ${1:-all} in
  all) format && tidy && sanitizers ;;
  format | tidy | sanitizers) "$@" ;;
  -h | --help) usage 0 ;;
  *) usage 2 >&2 ;;
esac
