#!/usr/bin/env bash
# Checks the packages that "cmake --build --preset packages" made, as who installs them meets them: what is in them,
# lintian's opinion, how exposed the service is, and in a bare Debian 12 that is made for it: install, run, map, serve,
# compile against the library, remove, purge; then the service, in that Debian booted as a container.
#   packaging/check.sh [FOLDER]     default: build/release/packages
# Needs lintian, root, mmdebstrap, systemd-nspawn (systemd-container), a mirror of Debian 12 in apt's own sources, and ROOMWISE_DATA (tum_fr1_desk_9frames).
# Exit code 0: all checked and right; 1: something is wrong; 77: the rest is right, but not all could be checked.
set -euo pipefail
repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
folder=$(cd "${1:-$repository/build/release/packages}" && pwd)
. "$repository/packaging/bare_debian.sh"

readonly names=(libroomwise-dev python3-roomwise roomwise roomwise-device roomwise-lab)
unchecked=()
heading() { printf '\n== %s\n' "$*"; }
fail() { printf 'WRONG: %s\n' "$*" >&2; exit 1; }
right() { printf 'right: %s\n' "$*"; }
not_checked() { printf 'NOT CHECKED: %s\n' "$*"; unchecked+=("$*"); }
package() { echo "$folder/$1"_*.deb; }
field() { dpkg-deb --field "$(package "$1")" "$2"; }

check_contents() {
  local name version
  version=$(field roomwise Version)
  for name in "${names[@]}"; do
    [ -f "$(package "$name")" ] || fail "$folder has no package $name: cmake --build --preset packages makes it"
    [ "$(field "$name" Version)" = "$version" ] || fail "$name is of another version than roomwise, $version"
    printf '%-18s %9d bytes packed, %7s KiB installed\n' "$name" "$(stat -c %s "$(package "$name")")" \
      "$(field "$name" Installed-Size)"
  done
  contains roomwise ./usr/bin/roomwise ./usr/share/roomwise/web/index.html ./lib/systemd/system/roomwise.service \
    ./usr/share/man/man1/roomwise.1.gz ./usr/share/man/man1/roomwise-serve.1.gz \
    ./usr/share/man/man1/roomwise-device.1roomwise.gz \
    ./usr/share/bash-completion/completions/roomwise ./usr/share/zsh/vendor-completions/_roomwise \
    ./usr/share/doc/roomwise/examples/haproxy.cfg "./usr/share/doc/roomwise/examples/roomwise-homes@.service"
  [[ $(files roomwise) == */networks/roomwise-*.onnx* ]] || fail "roomwise has no network"
  contains libroomwise-dev ./usr/include/roomwise/base/expected.h ./usr/lib/libroomwise_pipeline.a \
    ./usr/lib/cmake/Roomwise/RoomwiseConfig.cmake
  contains python3-roomwise ./usr/lib/python3/dist-packages/roomwise/__init__.py
  contains roomwise-lab ./usr/bin/roomwise-lab ./usr/share/man/man1/roomwise-lab.1.gz \
    ./usr/share/man/man1/roomwise-lab-simulate.1.gz ./usr/share/bash-completion/completions/roomwise-lab \
    ./usr/share/zsh/vendor-completions/_roomwise-lab
  [[ $(files roomwise-lab) != */bin/roomwise-train* ]] || contains roomwise-lab ./usr/share/man/man1/roomwise-train.1.gz \
    ./usr/share/bash-completion/completions/roomwise-train ./usr/share/zsh/vendor-completions/_roomwise-train
  contains roomwise-device ./usr/bin/roomwise-device ./usr/share/man/man1/roomwise-device.1.gz \
    ./usr/share/bash-completion/completions/roomwise-device ./usr/share/zsh/vendor-completions/_roomwise-device
  [[ ! $(field roomwise-device Depends) =~ libav|libopencv|libdnnl|libsqlite3 ]] ||
    fail "roomwise-device needs what only homes need: $(field roomwise-device Depends)"
  [[ $(field roomwise Depends) == *libc6*libicu72* ]] || fail "roomwise does not say which libraries it needs"
  [[ $(field libroomwise-dev Depends) == *libicu-dev* ]] || fail "libroomwise-dev does not say which libraries it needs"
  right "packages, contents, control fields"
}
files() { dpkg-deb --contents "$(package "$1")" | awk '{print $6}'; }
contains() {
  local name=$1 all file
  shift
  all=$'\n'$(files "$name")$'\n'
  for file in "$@"; do
    [[ $all == *$'\n'"$file"$'\n'* ]] || fail "$name has no $file"
  done
}

check_lintian() {
  command -v lintian >/dev/null || { not_checked "lintian is not installed"; return; }
  lintian --allow-root --fail-on error "$folder"/*.deb || fail "lintian finds errors"
  right "lintian finds no error"
}

# systemd-analyze counts from 0 to 10; --threshold is a tenth of that.
check_exposure() {
  command -v systemd-analyze >/dev/null || { not_checked "systemd-analyze is not installed"; return; }
  is_hidden "the service" "$repository/packaging/roomwise/roomwise.service"
  # A template is judged by one of what it makes.
  local one
  one=$(mktemp --directory)
  cp "$repository/packaging/homes/roomwise-homes@.service" "$one/roomwise-homes@1.service"
  is_hidden "the example for many homes" "$one/roomwise-homes@1.service"
  rm -r "$one"
}

is_hidden() {
  local said
  said=$(systemd-analyze security --offline=true --threshold=20 "$2") || fail "$1 is exposed by more than 2.0: ${said##*$'\n'}"
  right "$1: ${said##*→ }"
}

check_in_bare_debian() {
  local why
  why=$(why_no_bare_debian)
  [ -n "$why" ] || [ -d "${ROOMWISE_DATA:-}/tum_fr1_desk_9frames" ] || why="ROOMWISE_DATA has no tum_fr1_desk_9frames"
  [ -z "$why" ] || { not_checked "installing into a bare Debian 12: $why"; return; }
  root=$(mktemp -d /tmp/bare-debian.XXXXXX)
  chmod 755 "$root"
  trap 'leave_bare_debian "$root"' EXIT
  make_bare_debian "$root"
  mkdir "$root/packages"
  cp "$folder"/*.deb "$root/packages"
  cp -r --no-preserve=mode "$ROOMWISE_DATA/tum_fr1_desk_9frames" "$repository/packaging/use_library" \
    "$repository/examples" "$root/packages"
  install_dependencies
  state_of_bare_debian "$root" >"$root/packages/before"

  install_packages >"$root/packages/dpkg.log" 2>&1 || { cat "$root/packages/dpkg.log"; fail "dpkg"; }
  right "installed with nothing but what Depends names"
  use_program
  use_python
  use_laboratory
  use_library
  check_removal
  check_service
}
inside() { in_bare_debian "$root" "$@"; }
as_service() { inside setpriv --reuid roomwise --regid roomwise --clear-groups "$@"; }
install_packages() { inside sh -c "dpkg --install /packages/*.deb"; }

install_dependencies() {
  local name wanted=()
  for name in "${names[@]}"; do
    mapfile -t -O "${#wanted[@]}" wanted < <(field "$name" Depends | sed 's/, /\n/g' | grep -v '^roomwise ')
  done
  # What a compiler needs beside, for use_library.
  inside apt-get satisfy --yes --no-install-recommends "${wanted[@]}" cmake g++ make \
    >"$root/packages/apt.log" 2>&1 || { tail -n 20 "$root/packages/apt.log"; fail "dependencies cannot be installed"; }
}

readonly home=/var/lib/roomwise/home.home
use_program() {
  local said
  said=$(inside roomwise --version)
  [[ $said == *"$(field roomwise Version)"* ]] || fail "roomwise --version says $said"
  right "roomwise --version: $said"
  inside roomwise-device --help >"$root/packages/help" || fail "roomwise-device does not start"
  as_service roomwise map /packages/tum_fr1_desk_9frames --camera fr1 --no-networks --home $home
  as_service roomwise check $home
  right "a recording mapped and its home checked, as the service's user"
  serve_home
}
# As the unit does, on any free port; it ends in order when it is asked to.
serve_home() {
  local log=$root/packages/serve.log address tries=0 server
  : >"$log"
  as_service sh -c "echo \$\$ >/tmp/serve.pid; exec env HOME=/var/lib/roomwise roomwise serve $home --port 0" \
    </dev/null >"$log" 2>&1 &
  server=$!
  until grep -q '^Enter makes' "$log"; do
    if ! kill -0 $server 2>/dev/null || [ $((tries += 1)) -gt 300 ]; then
      cat "$log"
      fail "serve does not start"
    fi
    sleep 0.2
  done
  address=$(grep -o 'https://[^ ]*' "$log" | head -n 1)
  inside python3 -c "
import ssl, urllib.request
anyone = ssl._create_unverified_context()
for path, wanted in (('/health', b'ok'), ('/', b'<html')):
    page = urllib.request.urlopen('$address' + path, context=anyone).read()
    assert wanted in page, (path, page[:200])" || fail "serve does not answer"
  kill -TERM "$(cat "$root/tmp/serve.pid")"
  wait $server || { cat "$log"; fail "serve does not end in order"; }
  rm "$root/tmp/serve.pid"
  right "the home served: its state and pages by HTTPS"
}
use_python() {
  inside python3 -c "
import importlib.metadata, roomwise
assert roomwise.__version__ == importlib.metadata.version('roomwise') == '$(field roomwise Version)'
recording = roomwise.read_recording('/packages/tum_fr1_desk_9frames', camera='fr1')
assert sum(1 for _ in recording) == 9" || fail "Python"
  right "roomwise imported in Python, a recording read"
}
use_laboratory() {
  inside roomwise simulate --help >"$root/packages/help" || fail "roomwise does not start the laboratory's commands"
  right "the laboratory's commands start"
}
use_library() {
  inside sh -c 'cmake -S /packages/use_library -B /packages/used && cmake --build /packages/used &&
    /packages/used/examples/2_optimize_a_pose_graph' >"$root/packages/library.log" 2>&1 ||
    { tail -n 20 "$root/packages/library.log"; fail "the examples cannot be built with find_package(Roomwise)"; }
  right "the examples built with find_package(Roomwise), one run"
}

check_removal() {
  inside dpkg --remove "${names[@]}" >"$root/packages/remove.log" 2>&1 || { cat "$root/packages/remove.log"; fail "remove"; }
  [ -f "$root$home" ] || fail "removing took the home away"
  install_packages >>"$root/packages/remove.log" 2>&1 || fail "installing again"
  as_service roomwise check $home >"$root/packages/check.log" || fail "the home cannot be read after installing again"
  right "removed and installed again, the home stays"
  inside dpkg --purge "${names[@]}" | grep '/var/lib/roomwise' || fail "purging does not say what it removes"
  state_of_bare_debian "$root" >"$root/packages/after"
  diff "$root/packages/before" "$root/packages/after" || fail "something is left after purging (>) or is gone (<)"
  right "purged, nothing is left"
}

# As it is started in earnest: by systemd, in a container that is booted.
check_service() {
  heading "The service in a booted container"
  command -v systemd-nspawn >/dev/null || { not_checked "the service: systemd-nspawn is not installed"; return; }
  inside apt-get install --yes --no-install-recommends systemd systemd-sysv espeak-ng >"$root/packages/apt.log" 2>&1 ||
    { tail -n 20 "$root/packages/apt.log"; fail "systemd cannot be installed"; }
  install_packages >"$root/packages/dpkg.log" 2>&1 || fail "installing again"
  cp "$repository/packaging/use_service.sh" "$root/packages"
  cat >"$root/etc/systemd/system/use-service.service" <<'X'
[Unit]
After=multi-user.target
[Service]
Type=oneshot
ExecStart=/bin/sh -c '/packages/use_service.sh >/packages/service.log 2>&1'
ExecStopPost=/bin/systemctl --no-block poweroff
X
  mkdir -p "$root/etc/systemd/system/multi-user.target.wants"
  ln -s ../use-service.service "$root/etc/systemd/system/multi-user.target.wants"
  unmount_bare_debian "$root"
  timeout 300 systemd-nspawn --quiet --directory "$root" --register=no --keep-unit --private-network --boot \
    --console=pipe </dev/null >"$root/packages/boot.log" 2>&1 || true
  if [ ! -f "$root/packages/service.log" ]; then
    not_checked "the service: this machine lets no container boot: $(tail -n 1 "$root/packages/boot.log")"
  elif [ "$(tail -n 1 "$root/packages/service.log")" != "all right" ]; then
    cat "$root/packages/service.log"
    fail "the service does not do its work"
  else
    right "started by systemd, hardened: mapped with the network, served, spoke; neither enabled nor started by itself"
  fi
}

heading "Contents"
check_contents
heading "lintian"
check_lintian
heading "Exposure"
check_exposure
heading "Bare Debian 12"
check_in_bare_debian
if [ ${#unchecked[@]} -gt 0 ]; then
  heading "SKIPPED in part"
  printf '%s\n' "${unchecked[@]}"
  exit 77
fi
heading "All right"
