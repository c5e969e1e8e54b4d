# What ./test and ./demo share, to be sourced: the missing system packages, the build, the way to real data.
# Expects $root, the folder of the checkout.
# shellcheck shell=bash disable=SC2154

heading() { printf '\n== %s\n' "$*"; }
stop() { printf '%s: %s\n' "$(basename "$0")" "$*" >&2; exit 1; }

# install_missing_packages PART ...: installs what is missing of what cmake/packages.txt lists for these parts (product,
# laboratory, python, tests). Quick and without network when nothing is.
install_missing_packages() {
  if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    echo "This is no Debian system: the packages of cmake/packages.txt are taken to be installed." >&2
    return
  fi
  local wanted installed missing
  wanted=$(packages_of "$@" | needed_packages | sort -u)
  # dpkg-query fails where one of them is not known to it, and tells of the others all the same.
  # shellcheck disable=SC2086  # a list of names
  installed=$({ dpkg-query -W -f='${db:Status-Status} ${Package}\n' $wanted 2>/dev/null || true; } |
    awk '$1 == "installed" {print $2}' | sort -u)
  missing=$(comm -23 <(echo "$wanted") <(echo "$installed") | tr '\n' ' ')
  [ -n "${missing// /}" ] || return 0

  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null ||
      stop "packages are missing and there is no sudo; run as root: apt-get install --no-install-recommends $missing"
    as_root=(sudo)
  fi
  heading "Installing $missing"
  mkdir -p "$root/build"
  local log=$root/build/packages.log
  # shellcheck disable=SC2086
  apt_install $missing >"$log" 2>&1 ||
    { "${as_root[@]}" apt-get update >"$log" 2>&1 && apt_install $missing >>"$log" 2>&1; } || {
    tail -n 20 "$log" >&2
    stop "packages could not be installed; try: apt-get install --no-install-recommends $missing"
  }
}
# The lines of these parts.
packages_of() {
  awk -v parts=" $* " '{ sub(/#.*/, "") } /^\[/ { wanted = index(parts, " " substr($1, 2, length($1) - 2) " "); next }
    wanted && NF' "$root/cmake/packages.txt"
}
# Leaves out a package with "[command NAME]" where that command is there, wherever it came from; with
# "[command NAME VERSION]", where it is of that version or later.
needed_packages() {
  local package rest
  while read -r package rest; do
    if [[ ! $rest =~ ^\[command\ ([^] ]+)\ ?([0-9]*)\] ]] ||
      ! has_command "${BASH_REMATCH[1]}" "${BASH_REMATCH[2]:-0}"; then
      echo "$package"
    fi
  done
}
has_command() {
  command -v "$1" >/dev/null || return
  [ "$2" -eq 0 ] || { [[ $("$1" --version </dev/null 2>&1) =~ ([0-9]+) ]] && [ "${BASH_REMATCH[1]}" -ge "$2" ]; }
}
# Lists of packages that are old or not there yet make it fail; it is tried again with new ones.
apt_install() {
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install --yes --no-install-recommends "$@"
}

# build PRESET [TARGET ...]: configures and builds with every processor.
build() {
  local preset=$1
  shift
  mkdir -p "$root/build"
  cmake --preset "$preset" >"$root/build/configure-$preset.log" 2>&1 ||
    { cat "$root/build/configure-$preset.log" >&2; stop "cmake --preset $preset failed"; }
  cmake --build --preset "$preset" --parallel "$(nproc)" ${1:+--target "$@"}
}

# Real recordings and networks: where the caller says (relative to where the script was called), else beside the
# checkout.
find_real_data() {
  find_folder ROOMWISE_DATA ../shared/data
  find_folder ROOMWISE_MODELS ../shared/models
}
find_folder() {
  local variable=$1 folder=${!1:-}
  if [ -z "$folder" ]; then
    folder=$root/$2
    [ -d "$folder" ] || return 0
  elif [ "${folder#/}" = "$folder" ]; then
    folder=${OLDPWD:-$root}/$folder
  fi
  [ -d "$folder" ] || stop "$variable=${!variable} is no folder; give one that exists, or leave $variable unset"
  export "$variable=$(cd "$folder" && pwd)"
}
