#!/usr/bin/env bash
# Builds Roomwise for arm64 on Debian 12 for amd64, from nothing to packages (docs/packages.md):
#   packaging/arm64.sh                   packages in build/arm64/packages, what roomwise-device pulls in, how large all is
#   packaging/arm64.sh device            the package roomwise-device alone, which is built in a fraction of the time
#   packaging/arm64.sh test MODULE ...   the tests of these modules (features, motion, mapping, ...) under qemu
#   packaging/arm64.sh digest RECORDING CAMERA    the recording mapped under qemu, by NEON and without: the homes' digests
# Nothing of arm64 is installed on this machine: what is compiled against is unpacked into build/arm64-root, or the folder
# that ROOMWISE_ARM64_ROOT names. As many processes as ROOMWISE_JOBS says; default: all processors.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
. "$root/cmake/setup.sh"
. "$root/packaging/bare_debian.sh"
. "$root/packaging/arm64_root.sh"
cd "$root"
export ROOMWISE_ARM64_ROOT=${ROOMWISE_ARM64_ROOT:-$root/build/arm64-root}
jobs=${ROOMWISE_JOBS:-$(nproc)}

prepare() {
  install_missing_packages arm64
  [ -n "$(debian_sources)" ] || stop "apt's lists have no Debian 12: run 'apt-get update'"
  heading "Debian for arm64 in $ROOMWISE_ARM64_ROOT"
  # libblas, liblapack: of all that provide what Ceres links, one.
  # shellcheck disable=SC2046  # a list of names
  make_arm64_root "$ROOMWISE_ARM64_ROOT" libc6-dev libstdc++6 libblas-dev liblapack-dev \
    $(packages_of product tests | awk '$1 ~ /-dev$/ { print $1 }') >"$root/build/arm64-root.log" 2>&1 ||
    { tail -n 20 "$root/build/arm64-root.log" >&2; stop "what to compile against could not be had"; }
}
build_for_arm64() {
  heading "Building $*"
  cmake --preset "$1" >"$root/build/configure-$1.log" 2>&1 ||
    { cat "$root/build/configure-$1.log" >&2; stop "cmake --preset $1 failed"; }
  cmake --build --preset "$1" --parallel "$jobs" ${2:+--target "${@:2}"}
}
emulated() { qemu-aarch64-static -L "$ROOMWISE_ARM64_ROOT" "$@"; }

# Every package that a Debian without any would get with the one in this file, and its size in KiB.
pulled_in() {
  apt_of_arm64 "$ROOMWISE_ARM64_ROOT" install --simulate --no-install-recommends -o Dir::State::status=/dev/null "$@" |
    awk '/^Inst / { print $2 }' | sort -u | while read -r name; do
    [ "$name" != roomwise-device ] || continue
    APT_CONFIG=$ROOMWISE_ARM64_ROOT/etc/apt/arm64.conf apt-cache show --no-all-versions "$name" |
      awk -v name="$name" '/^Installed-Size:/ { print $2, name }'
  done
}
show_sizes() {
  local package=$1 listed
  heading "Installed with $(basename "$package"), KiB"
  listed=$(pulled_in "$package"; echo "$(dpkg-deb --field "$package" Installed-Size) roomwise-device")
  sort -rn <<<"$listed"
  awk '{ sum += $1 } END { printf "%.1f MB in all\n", sum * 1024 / 1e6; exit sum * 1024 >= 60e6 }' <<<"$listed" ||
    stop "roomwise-device takes 60 MB or more"
}

make_packages() {
  build_for_arm64 arm64
  show_sizes "$(ls "$root"/build/arm64/packages/roomwise-device_*_arm64.deb)"
}
make_device_package() {
  build_for_arm64 arm64 roomwise-device
  (cd build/arm64 && cpack -D CPACK_COMPONENTS_ALL=device)
  show_sizes "$(ls "$root"/build/arm64/packages/roomwise-device_*_arm64.deb)"
}
run_tests() {
  build_for_arm64 arm64-tests "${@/%/_test}"
  local modules="$*"
  ctest --preset arm64 --parallel "$jobs" --tests-regex "^(${modules// /|})\."
}
compare_digests() {
  local homes simd
  build_for_arm64 arm64 roomwise
  homes=$(mktemp -d)
  # shellcheck disable=SC2064  # as it is now
  trap "rm -rf '$homes'" EXIT
  for simd in neon portable; do
    ROOMWISE_SIMD=$simd emulated build/arm64/bin/roomwise map "$1" --camera "$2" --no-networks --home "$homes/$simd.home"
    emulated build/arm64/bin/roomwise info "$homes/$simd.home" --digest
  done
}

prepare
case ${1:-} in
  "") make_packages ;;
  device) make_device_package ;;
  test) [ $# -gt 1 ] || stop "give the modules: packaging/arm64.sh test features"; run_tests "${@:2}" ;;
  digest) [ $# -eq 3 ] || stop "give the recording and its camera"; compare_digests "$2" "$3" ;;
  *) stop "'$1' is neither device, test nor digest" ;;
esac
