#!/usr/bin/env bash
# tests/check.sh tidy in a small repository with a stand-in for clang-tidy: which files it is given, and that nothing is
# left out in silence.
#
#   tests/check_test.sh SCRATCH
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
scratch=$1
rm -rf "$scratch"
mkdir -p "$scratch/bin" "$scratch/repository/tests" "$scratch/repository/room" "$scratch/repository/build/release"
cd "$scratch/repository"
export PATH=$scratch/bin:$PATH C3RT_JOBS=1 GIT_CONFIG_GLOBAL=/dev/null
failures=0

# the stand-in notes the file; one with the word "unreadable" is one that it cannot read
cat >"$scratch/bin/clang-tidy" <<'END'
#!/usr/bin/env bash
if [[ $1 == --version ]]; then echo "LLVM version 14.0.6"; exit; fi
file=${!#}
echo "$file" >>"$SEEN"
echo "1000 warnings generated." >&2
if grep -q unreadable "$file"; then echo "$file: error: no such header [clang-diagnostic-error]" >&2; exit 1; fi
END
chmod +x "$scratch/bin/clang-tidy"
export SEEN=$scratch/seen

# tidy ARGUMENT...: what check.sh says and the files that clang-tidy saw
tidy() {
  : >"$SEEN"
  status=0
  bash tests/check.sh tidy "$@" >"$scratch/said" 2>&1 || status=$?
  seen=$(sort "$SEEN" | tr '\n' ' ')
}
expect() {
  if [[ $2 != "$3" ]]; then
    printf 'check: %s: expected "%s", got "%s"\n' "$1" "$3" "$2" >&2
    cat "$scratch/said" >&2
    failures=$((failures + 1))
  fi
}

cp "$here/check.sh" tests/
echo build >.gitignore
echo 'Checks: "*"' >.clang-tidy
echo '#pragma once' >room/shared.hpp
for name in a b c; do printf '#include "room/shared.hpp"\n' >room/$name.cpp; done
echo '// alone' >room/c.cpp
echo '// a test' >tests/a_test.cpp
git init -q .
git add .
commit() { git -c user.name=c3rt -c user.email=c3rt@localhost commit -qam "$1"; }
commit first

tidy
expect "without a build it is red" "$status:$seen" "1:"

# a build that compiles a, b and c as the real one does
cat >build/release/build.ninja <<END
rule compile
  command = c++ -I$PWD -I../.. -MD -MF \$out.d -c \$in -o \$out
  deps = gcc
  depfile = \$out.d
END
{
  separator='['
  for name in a b c; do
    printf '%s\n{\n  "file": "%s/room/%s.cpp"\n}' "$separator" "$PWD" "$name"
    separator=,
    path=$PWD
    [[ $name != b ]] || path=../..  # as with a compiler cache
    printf 'build %s.o: compile %s/room/%s.cpp\n' "$name" "$path" "$name" >>build/release/build.ninja
  done
  printf '\n]\n'
} >build/release/compile_commands.json
ninja -C build/release >/dev/null

tidy
expect "all files but the tests" "$status:$seen" "0:room/a.cpp room/b.cpp room/c.cpp "
tidy room/b.cpp
expect "those that are named" "$status:$seen" "0:room/b.cpp "
tidy --since HEAD
expect "nothing has changed" "$status:$seen" "0:"

echo '// changed' >>room/c.cpp
tidy --since HEAD
expect "a source that changed" "$status:$seen" "0:room/c.cpp "
echo '// changed' >>room/shared.hpp
tidy --since HEAD
expect "sources that include what changed" "$status:$seen" "0:room/a.cpp room/b.cpp room/c.cpp "
git checkout -q room
echo '# other rules' >>.clang-tidy
tidy --since HEAD
expect "other rules concern all" "$status:$seen" "0:room/a.cpp room/b.cpp room/c.cpp "
git checkout -q .clang-tidy
tidy --since 0000000000000000000000000000000000000000
expect "a commit that is not there is red" "$status:$seen" "1:"

# a build that joins two sources: each is read by itself
mkdir -p build/release/Unity
printf '#include "%s/room/%s.cpp"\n' "$PWD" a "$PWD" c >build/release/Unity/unity_0_cxx.cxx
{
  printf '[\n{"file": "%s/build/release/Unity/unity_0_cxx.cxx", "command": "c++ -I%s -include x/cmake_pch.hxx -c %s/build/release/Unity/unity_0_cxx.cxx"},\n' "$PWD" "$PWD" "$PWD"
  printf '{"file": "%s/room/b.cpp", "command": "c++ -c %s/room/b.cpp"}\n]\n' "$PWD" "$PWD"
} >build/release/compile_commands.json
cat >build/release/build.ninja <<END
rule compile
  command = c++ -I$PWD -MD -MF \$out.d -c \$in -o \$out
  deps = gcc
  depfile = \$out.d
build joined.o: compile $PWD/build/release/Unity/unity_0_cxx.cxx
build b.o: compile $PWD/room/b.cpp
END
ninja -C build/release >/dev/null
tidy
expect "joined sources are read one by one" "$status:$seen" "0:room/a.cpp room/b.cpp room/c.cpp "
expect "with their own commands" "$(grep -c -- "-c $PWD/room/c.cpp" build/tidy/compile_commands.json):$(grep -c 'cmake_pch\|Unity' build/tidy/compile_commands.json)" "1:0"
echo '// changed' >>room/c.cpp
tidy --since HEAD
expect "of joined sources the one that changed" "$status:$seen" "0:room/c.cpp "
git checkout -q room

echo '// new' >room/d.cpp
git add room/d.cpp
tidy --since HEAD
expect "a new source that no build compiles is red" "$status:$seen" "1:"
git rm -qf room/d.cpp

echo '// unreadable' >>room/a.cpp
tidy
expect "a file that cannot be read is red and the others are looked at" "$status:$seen" "1:room/a.cpp room/b.cpp room/c.cpp "
expect "and it is said why" "$(grep -c 'clang-diagnostic-error' "$scratch/said")" 1
git checkout -q room
echo '// new' >room/d.cpp
git add room/d.cpp
tidy
expect "a file that no build compiles is red" "$status:$seen" "1:"
expect "and named" "$(grep -c 'room/d.cpp is not compiled' "$scratch/said")" 1

((failures == 0))
