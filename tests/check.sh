#!/usr/bin/env bash
# What a reviewer should not have to look for. Beside the test suite, and like it part of continuous integration.
#
#   tests/check.sh                     format, then tidy, then sanitizers
#   tests/check.sh format              the sources are as .clang-format has them; --fix makes them so
#   tests/check.sh tidy [FILE...]      clang-tidy's checks of .clang-tidy, of these files or of all but the tests'
#   tests/check.sh tidy --since COMMIT the same of the files that changed since then or include what did
#   tests/check.sh sanitizers          the unit and property tests under address and undefined-behaviour sanitizers
#   tests/check.sh sanitizers --whole  the same of the whole suite, with its processes; not part of continuous integration
#   tests/check.sh threads             the tests of what has threads under the thread sanitizer; not part of it either
#   tests/check.sh fuzz [SAMPLES [FILES]]  so many samples of the topics (default: 10^7) and mutated files of all kinds (10^6) by
#                                      libFuzzer, under both sanitizers; not part of it: hours. What it finds stays in build/fuzz/found
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
  sed -n 's/^# \{0,1\}//; 2,14p' "${BASH_SOURCE[0]}"
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

# with_changes COMMIT: of our sources those that changed since it or include what did
with_changes() {
  local -a changed
  mapfile -t changed < <(git diff --name-only --diff-filter=d "$1" -- '*.cpp' '*.hpp')
  ((${#changed[@]})) || return 0
  printf '%s\n' "${changed[@]}"
  # what the compiler read for an object: its source, or several that were joined, and all they include; ccache may have made
  # their paths relative
  ninja -C build/release -t deps | awk -v root="$root/" '
    function tell() { if (concerned) printf "%s", sources; sources = ""; concerned = 0 }
    NR == FNR { if ($0 !~ /\.cpp$/) changed[root $0]; next }
    /^[^ ]/ { tell() }
    /^ / {
      file = $1; sub(/^\.\.\/\.\.\//, root, file)
      if (file in changed) concerned = 1
      if (index(file, root) == 1 && file ~ /\.cpp$/) sources = sources substr(file, length(root) + 1) "\n"
    }
    END { tell() }
  ' <(printf '%s\n' "${changed[@]}") -
}

# one clang-tidy; what it says is shown whole, also what keeps it from reading a file, if there is anything
tidy_one() {
  local said
  said=$(clang-tidy -p "$tidy_folder" --quiet --warnings-as-errors='*' "$@" 2>&1) && return
  printf '%s\n' "$said" | sed '/^[0-9]* warnings\{0,1\} generated\.$/d' >&2
  return 1
}

tidy() {
  need clang-tidy
  local -r compiled=build/release/compile_commands.json
  [[ -f $compiled ]] || fail "no $compiled: run ./c3rt build first"
  local -a files
  mapfile -t files < <(git ls-files -- '*.cpp' ':!tests')
  if [[ ${1:-} == --since ]]; then
    git rev-parse --quiet --verify "$2^{commit}" >/dev/null || fail "--since: expected a commit, got $2"
    git diff --quiet "$2" -- .clang-tidy || set --  # another rule concerns every file
    if (($#)); then
      mapfile -t files < <(with_changes "$2" | grep -Fx -f <(printf '%s\n' "${files[@]}") | sort -u)
    fi
  elif (($#)); then
    files=("$@")
  fi
  # the same commands for each source by itself, without GCC's own options and precompiled headers, which clang does not read: so every source
  # is also read with what it includes itself and nothing else
  export tidy_folder=build/tidy
  mkdir -p "$tidy_folder"
  python3 - "$compiled" >"$tidy_folder/compile_commands.json" <<'END'
import json, pathlib, re, sys
entries = []
for entry in json.load(open(sys.argv[1])):
    entry["command"] = re.sub(r" -Winvalid-pch| -fpch-preprocess| -Wno-subobject-linkage| -include \S*cmake_pch\.hxx", "", entry.get("command", ""))
    joined = entry["file"]
    sources = [joined]
    if "/Unity/" in joined:
        sources = re.findall(r'^#include "(.+)"$', pathlib.Path(joined).read_text(), re.MULTILINE)
    for source in sources:
        entries.append({**entry, "command": entry["command"].replace(joined, source), "file": source})
json.dump(entries, sys.stdout, indent=0)
END
  local file
  for file in "${files[@]}"; do
    # clang-tidy would guess how to compile it
    grep -qF "\"file\": \"$root/$file\"" "$tidy_folder/compile_commands.json" || fail "$file is not compiled by build/release: no CMakeLists.txt names it, or its library is not installed"
  done
  printf 'check: tidy: %s files\n' "${#files[@]}"
  ((${#files[@]})) || return 0
  export -f tidy_one
  printf '%s\0' "${files[@]}" | xargs -0 -n 1 -P "$jobs" bash -c 'tidy_one "$@" || exit 1' tidy_one ||
    fail "clang-tidy has something to say: see above"
}

sanitizers() {
  local -a build=(unit_tests) choice=(--label-regex '^(unit|property)$')
  case ${1:-} in
    '') ;;
    --whole) build=(all) choice=() ;;
    *) usage 2 >&2 ;;
  esac
  cmake --preset asan >/dev/null
  ninja -C build/asan -j "$jobs" --quiet "${build[@]}" || fail "the sanitized tests do not build"
  ctest --preset asan --no-tests=error "${choice[@]}" || fail "a sanitized test failed: see above"
}

# The rooms whose code runs in several threads; the client in Python has its own Cyclone.
threads() {
  cmake --preset tsan >/dev/null
  local -a built
  mapfile -t built < <(ninja -C build/tsan -t targets all |
    sed -nE 's/^(test_(idl|controller_rt|controller_impedance|controller_planner|vision)(_[a-z0-9_]+)?): phony$/\1/p')
  ((${#built[@]})) || fail "build/tsan has no tests"
  ninja -C build/tsan -j "$jobs" --quiet programs "${built[@]}" || fail "the tests do not build"
  ctest --preset tsan --no-tests=error -R '^(idl|controller/(rt|impedance|planner)|vision)/' -E python_client ||
    fail "a test failed under the thread sanitizer: see above"
}

# fuzz_one KIND RUNS: its corpus grows in build/fuzz/found, where the next call goes on
fuzz_one() {
  local -r kind=$1 runs=$2 found=build/fuzz/found/$1 log=build/fuzz/found/$1.log
  local -a seeds=("tests/fuzz/corpus/$kind")
  [[ $kind != scenario ]] || seeds+=(config/scenarios)
  mkdir -p "$found"
  printf 'check: fuzz: %s: %s inputs; how far: %s\n' "$kind" "$runs" "$log"
  "build/fuzz/tests/fuzz/c3rt_fuzz_$kind" -runs="$runs" -timeout=20 -rss_limit_mb=4096 -print_final_stats=1 -artifact_prefix="build/fuzz/found/$kind-" \
    "$found" "${seeds[@]}" >"$log" 2>&1 || { tail -n 40 "$log" >&2; return 1; }
  printf 'check: fuzz: %s: %s inputs, nothing found\n' "$kind" "$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")"
}

fuzz() {
  local -r samples=${1:-10000000} files=${2:-1000000}
  [[ $samples$files =~ ^[0-9]+$ ]] || usage 2 >&2
  local -r kinds=(problem_file scenario mesh mcap)
  cmake --preset fuzz >/dev/null
  ninja -C build/fuzz -j "$jobs" --quiet c3rt_fuzz_wire "${kinds[@]/#/c3rt_fuzz_}" || fail "the fuzzers do not build"
  export -f fuzz_one
  { printf 'wire %s\n' "$samples"; printf "%s $((files / ${#kinds[@]}))\n" "${kinds[@]}"; } |
    xargs -n 2 -P "$jobs" bash -c 'fuzz_one "$@" || exit 1' fuzz_one || fail "an input ended a fuzzer: see above, and build/fuzz/found"
}

case ${1:-all} in
  all)
    format
    tidy
    sanitizers
    ;;
  format | tidy | sanitizers | threads | fuzz) "$@" ;;
  -h | --help) usage 0 ;;
  *) usage 2 >&2 ;;
esac
