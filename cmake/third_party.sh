#!/usr/bin/env bash
# Fetches, checks, unpacks and builds the pinned source releases of OSQP and Pinocchio under build/third_party, and
# installs the packages of Python that tests need there.
# Nothing of them is committed; a second run finds the stamps and does nothing.
#
#   cmake/third_party.sh [DIRECTORY]        default: build/third_party
set -euo pipefail

root=$(cd "$(dirname "$0")/.." && pwd)
directory=${1:-$root/build/third_party}
prefix=$directory/prefix
jobs=${C3RT_JOBS:-$(nproc)}
compiler_launcher=()
command -v ccache >/dev/null && compiler_launcher=(-DCMAKE_C_COMPILER_LAUNCHER=ccache -DCMAKE_CXX_COMPILER_LAUNCHER=ccache)

say() { printf '[third party] %s\n' "$*"; }
fail() { printf 'c3rt: error: %s\n' "$*" >&2; exit 2; }

# fetch NAME==VERSION FILE SHA256: the source release, downloaded without running its build
fetch() {
  local requirement=$1 file=$2 expected=$3
  if [[ ! -f $directory/download/$file ]]; then
    if [[ ! -x $directory/tools/bin/unearth ]]; then
      say "installing the downloader (unearth) into a virtual environment"
      /usr/bin/python3 -m venv "$directory/tools"
      # pinned: version 0.17 unpacks what it downloads, so that nothing is left to check
      "$directory/tools/bin/pip" --quiet install 'unearth==0.19.0' ||
        fail "could not install the downloader; is the package index reachable?"
    fi
    say "downloading $requirement"
    mkdir -p "$directory/download"
    "$directory/tools/bin/unearth" --no-binary --download "$directory/download" "$requirement" >"$directory/download.log" 2>&1 ||
      { tail -n 5 "$directory/download.log" >&2; fail "could not download $requirement; is the package index reachable?"; }
  fi
  [[ -f $directory/download/$file ]] || fail "$requirement was downloaded, but $file is not in $directory/download"
  local actual
  actual=$(sha256sum "$directory/download/$file" | cut -d' ' -f1)
  [[ $actual == "$expected" ]] ||
    fail "$file: expected sha256 $expected, got $actual; delete $directory/download/$file and run again"
}

# run LOG COMMAND...: quiet unless it fails
run() {
  local log=$1
  shift
  "$@" >"$log" 2>&1 || { tail -n 30 "$log" >&2; fail "failed: $* (whole log: $log)"; }
}

mkdir -p "$directory"

osqp_stamp=$prefix/.osqp-0.6.3
if [[ ! -f $osqp_stamp ]]; then
  fetch 'osqp==0.6.7.post3' osqp-0.6.7.post3.tar.gz b0c5e0a721f21c9724097a4fd50108304d296468d124e16f34ac67046f7020e1
  say "building OSQP 0.6.3"
  rm -rf "$directory/osqp" && mkdir -p "$directory/osqp"
  tar -xzf "$directory/download/osqp-0.6.7.post3.tar.gz" -C "$directory/osqp" --strip-components=1
  # the release leaves the demo's source out, but its CMakeLists.txt names it
  mkdir -p "$directory/osqp/osqp_sources/examples"
  echo 'int main(void) { return 0; }' >"$directory/osqp/osqp_sources/examples/osqp_demo.c"
  run "$directory/osqp.log" cmake -S "$directory/osqp/osqp_sources" -B "$directory/osqp/build" -G Ninja \
    -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX="$prefix" -DCMAKE_POSITION_INDEPENDENT_CODE=ON \
    -DCMAKE_C_FLAGS=-ffp-contract=off -DPRINTING=OFF -DPROFILING=OFF -DCTRLC=OFF -DENABLE_MKL_PARDISO=OFF -DUNITTESTS=OFF \
    "${compiler_launcher[@]}"
  run "$directory/osqp.log" cmake --build "$directory/osqp/build" --target osqpstatic -j "$jobs"
  mkdir -p "$prefix/lib" "$prefix/include/osqp"
  cp "$directory/osqp/build/out/libosqp.a" "$prefix/lib/"
  cp "$directory"/osqp/osqp_sources/include/*.h "$prefix/include/osqp/"
  touch "$osqp_stamp"
fi

pinocchio_stamp=$prefix/.pinocchio-3.4.0
if [[ ! -f $pinocchio_stamp ]]; then
  fetch 'pin==3.4.0' pin-3.4.0.tar.gz 95c8e9c707dad9c412247874ca3f8ac77f0d5f51e49f02856f88146478e2660b
  say "installing Pinocchio 3.4.0"
  rm -rf "$directory/pinocchio" && mkdir -p "$directory/pinocchio"
  tar -xzf "$directory/download/pin-3.4.0.tar.gz" -C "$directory/pinocchio" --strip-components=1
  # its headers are all that is used (controller/model/arm.cpp reads the URDF): without its readers nothing much is compiled
  sed -i 's|[^ ]*/src/parsers/mjcf/mjcf-graph[a-z-]*\.cpp||' "$directory/pinocchio/sources.cmake"
  run "$directory/pinocchio.log" cmake -S "$directory/pinocchio" -B "$directory/pinocchio/build" -G Ninja \
    -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX="$prefix" \
    -DENABLE_TEMPLATE_INSTANTIATION=OFF -DBUILD_PYTHON_INTERFACE=OFF -DBUILD_TESTING=OFF -DBUILD_BENCHMARK=OFF \
    -DBUILD_EXAMPLES=OFF -DBUILD_WITH_COLLISION_SUPPORT=OFF -DBUILD_WITH_SDF_SUPPORT=OFF -DBUILD_WITH_URDF_SUPPORT=OFF \
    "${compiler_launcher[@]}"
  run "$directory/pinocchio.log" cmake --build "$directory/pinocchio/build" --target install -j "$jobs"
  # the Panda's description travels with Pinocchio's source release (Apache-2.0)
  mkdir -p "$prefix/share/panda_description"
  cp -r "$directory/pinocchio/models/example-robot-data/robots/panda_description/." "$prefix/share/panda_description/"
  touch "$pinocchio_stamp"
fi
# Packages of Python, of which each version is one file: cyclonedds for the test of a client in Python, mcap and what it needs
# for the test of recordings, mujoco for a planner of examples/, cmaes for c3rt tune, the others to build and test python/. Nothing else here needs them; without them those tests are skipped and the extension is left out.
python_packages="
cyclonedds==11.0.1 --hash=sha256:dce635041d42e954a5fec187dabf99d4b36c9daa54cc97d6d2238985e3ef6101
nanobind==3.1.0 --hash=sha256:96984dbe8154ffb86e653b1b60aaeed6985c710c5e75ad0279eb87943c66292d
scikit-build-core==1.1.2 --hash=sha256:7f4f959a467692db50bdd1ea7ce1507f2c7972e6023b753ee302d169bc4cec85
packaging==26.4 --hash=sha256:81383611a09c1bc0b08b76e0fd5829d7c6824c65b27a6aee339da133f4233ea2
pathspec==1.1.1 --hash=sha256:a00ce642f577bf7f473932318056212bc4f8bfdf53128c78bbd5af0b9b20b189
numpy==2.4.6 --hash=sha256:89cd468399cfd2504718f0ba50e410dca55a170b61a02ad92bb18c8a65186e93
pytest==9.2.0 --hash=sha256:07acdcf88ec174f907dc01af70bf52d49b014bbab03faeeade31c96b18c2e588
iniconfig==2.3.1 --hash=sha256:9121e2c1fdb355232495be3194c8dfe87ccc2d5dee45947b78e68f499790d7a7
pluggy==1.7.0 --hash=sha256:7dd7b0d8832ba3cb632c306926ded123429211b83641b35dc5c41ad2d34f9bec
pygments==2.21.0 --hash=sha256:2363c69b61c4a97c838da3b130dcd6468f4848992b21a82f2a63ec34377137d9
mcap==1.6.0 --hash=sha256:7cd37fba2cf51d033f2139ca837d2ed3024dcec3cd9f8ecdf3d4d15930df6e17
zstandard==0.25.0 --hash=sha256:9300d02ea7c6506f00e627e287e0492a5eb0371ec1670ae852fefffa6164b072
pandas==2.3.3 --hash=sha256:b98560e98cb334799c0b07ca7967ac361a47326e9b4e5a7dfb5ab2b1c9d35a1b
python-dateutil==4.0.0 --hash=sha256:a5e246f79eb80475e691bf93862cead98decd8a498cf53ba0516fcdc0f50dc1c
pytz==2026.6 --hash=sha256:7fed3fee8fd6bd4a2b7b75a8d56021d0624127bf69bd5691f115db929ac570b3
tzdata==2026.6 --hash=sha256:0a10eec6e13ef16b627fabed9a5f2ba61a62b1c67f327305f4e7e412a70b4aec
lz4==4.4.5 --hash=sha256:75419bb1a559af00250b8f1360d508444e80ed4b26d9d40ec5b09fe7875cb989
gymnasium==1.4.0 --hash=sha256:1cb947c59e7c72d8eabb2c2274c00cd20948e69f8452a9ef4092223be24fdf0e
farama-notifications==0.0.6 --hash=sha256:f84839188efa1ce5bb361c2a84881b2dc2c0d0d7fb661ff00421820170930935
cloudpickle==3.1.3 --hash=sha256:1654f4f18e416447210a63c5c25a135d65a292156aa5fa519dfa4baf7726dddb
typing-extensions==4.16.0 --hash=sha256:481caa481374e813c1b176ada14e97f1f67a4539ce9cfeb3f350d78d6370c2e8
cmaes==0.13.1 --hash=sha256:659881b1d574adf0b378448821e3da24a4f7b7a1989640cd902000c567897db5
mujoco==3.3.2 --hash=sha256:f7e19ef4ded262d9ff454ac9346203dcb35a6f794e7d9406ee803f1c73702560
"
# another list is another stamp; what is there already stays
python_stamp=$directory/python/.packages-$(sha256sum <<<"$python_packages" | cut -c1-16)
if [[ ! -f $python_stamp ]]; then
  say "installing packages of Python into a virtual environment"
  # cyclonedds and numpy: the wheels of Debian 12's Python 3.11
  if /usr/bin/python3 -m venv "$directory/python" &&
    "$directory/python/bin/python" -m pip --quiet install --no-deps --only-binary :all: --require-hashes \
      --requirement <(printf '%s' "$python_packages") >"$directory/python.log" 2>&1; then
    touch "$python_stamp"
  else
    tail -n 3 "$directory/python.log" >&2 || true
    say "the packages of Python could not be had: the tests idl/python_client and python/library will be skipped"
  fi
fi
say "ready in $prefix"
