#!/usr/bin/env bash
# Are packages the same bytes when they are built again? Compares those in build/release/packages, however they were made,
# with what is built without the compiler's cache:
#   packaging/reproducible.sh              all of it, from a clone of the last commit in another folder: a whole first build
#   packaging/reproducible.sh TARGET ...   in build/release: these targets (roomwise_guide, web, roomwise-device, ...) and all
#                                          that they need made anew, the rest linked and packed as it lies there
# As many processes as ROOMWISE_JOBS says; default: all processors.
# Exit code 0: the same bytes; 1: not the same, and it says what differs; both sets of packages are kept then.
set -euo pipefail
repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$repository"
jobs=${ROOMWISE_JOBS:-$(nproc)}
export CCACHE_DISABLE=1
umask 022

heading() { printf '\n== %s\n' "$*"; }
stop() { printf '%s: %s\n' "$(basename "$0")" "$*" >&2; exit 1; }

# The folder with the second packages is set as $second.
build_in_a_clone() {
  [ -z "$(git status --porcelain)" ] || stop "what is not committed is not in a clone: commit it"
  git clone --quiet --shared "$repository" "$work/clone"
  (cd "$work/clone" && cmake --preset packages >"$work/configure.log" && cmake --build --preset packages --parallel "$jobs")
  second=$work/clone/build/release/packages
}
build_anew() {
  cmake --preset packages >"$work/configure.log"
  mkdir "$work/first"
  cp build/release/packages/*.deb "$work/first"
  first=$work/first
  ninja -C build/release -t clean "$@"
  cmake --build --preset packages --parallel "$jobs"
  second=$repository/build/release/packages
}

# says_difference NAME: what of this package is not the same.
says_difference() {
  local side
  for side in first second; do
    mkdir -p "$work/$side.of/$1"
    dpkg-deb --raw-extract "${!side}/$1" "$work/$side.of/$1"
    dpkg-deb --contents "${!side}/$1" >"$work/$side.of/$1.contents"
  done
  diff -rq "$work/first.of/$1" "$work/second.of/$1" | sed "s|$work/||g" || true
  diff "$work/first.of/$1.contents" "$work/second.of/$1.contents" || true
}
compare() {
  local package name different=0
  [ "$(cd "$first" && ls ./*.deb)" = "$(cd "$second" && ls ./*.deb)" ] || stop "not the same packages: $first, $second"
  for package in "$first"/*.deb; do
    name=$(basename "$package")
    if cmp --silent "$package" "$second/$name"; then
      printf 'the same  %s  %s\n' "$(sha256sum <"$package" | cut -c 1-16)" "$name"
    else
      printf 'DIFFERENT %s\n' "$name"
      says_difference "$name"
      different=1
    fi
  done
  return $different
}

first=$repository/build/release/packages
compgen -G "$first/*.deb" >/dev/null || stop "$first has no packages: cmake --build --preset packages makes them"
work=$(mktemp -d /tmp/reproducible.XXXXXX)
heading "Building again without the compiler's cache"
if [ $# -eq 0 ]; then build_in_a_clone; else build_anew "$@"; fi
heading "Compared"
compare || stop "not the same bytes; compared were $first and $second"
rm -rf "$work"
