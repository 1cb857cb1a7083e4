#!/usr/bin/env bash
# What a reviewer should not have to look for. Beside the test suite, and like it part of continuous integration.
#
#   tests/check.sh                     format, then tidy, then sanitizers
#   tests/check.sh format              the sources are as .clang-format has them; --fix makes them so
#   tests/check.sh tidy [FILE...]      clang-tidy's checks of .clang-tidy, of these files or of all but the tests'
#   tests/check.sh tidy --since COMMIT the same of the files that changed since then or include what did
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
  sed -n 's/^# \{0,1\}//; 2,11p' "${BASH_SOURCE[0]}"
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
  # the first of the files that the compiler read is the source itself; ccache may have made their paths relative
  ninja -C build/release -t deps | awk -v root="$root/" '
    NR == FNR { changed[root $0]; next }
    /^[^ ]/ { source = "" }
    /^ / { file = $1; sub(/^\.\.\/\.\.\//, root, file); if (source == "") source = file; if (file in changed) print substr(source, length(root) + 1) }
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
  # the same commands without GCC's precompiled headers, which clang does not read: so every source is also read with what it
  # includes itself and nothing else
  export tidy_folder=build/tidy
  mkdir -p "$tidy_folder"
  sed -E 's/ -Winvalid-pch| -fpch-preprocess| -include [^ ]*cmake_pch\.hxx//g' "$compiled" >"$tidy_folder/compile_commands.json"
  local file
  for file in "${files[@]}"; do
    # clang-tidy would guess how to compile it
    grep -qF "\"file\": \"$root/$file\"" "$compiled" || fail "$file is not compiled by build/release: no CMakeLists.txt names it, or its library is not installed"
  done
  printf 'check: tidy: %s files\n' "${#files[@]}"
  ((${#files[@]})) || return 0
  export -f tidy_one
  printf '%s\0' "${files[@]}" | xargs -0 -n 1 -P "$jobs" bash -c 'tidy_one "$@" || exit 1' tidy_one ||
    fail "clang-tidy has something to say: see above"
}

sanitizers() {
  cmake --preset asan >/dev/null
  ninja -C build/asan -j "$jobs" --quiet unit_tests || fail "the sanitized tests do not build"
  ctest --preset asan --no-tests=error --label-regex '^(unit|property)$' ||
    fail "a sanitized test failed: see above"
}

case ${1:-all} in
  all)
    format
    tidy
    sanitizers
    ;;
  format | tidy | sanitizers) "$@" ;;
  -h | --help) usage 0 ;;
  *) usage 2 >&2 ;;
esac
