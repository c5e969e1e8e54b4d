# A Debian 12 of nothing but what every Debian has and apt, in a folder; to be sourced.
# shellcheck shell=bash

# The sources that this machine's apt has of Debian 12 itself, as lines of sources.list.
debian_sources() {
  # shellcheck disable=SC2016  # apt fills these in
  apt-get indextargets --format 'deb $(REPO_URI) $(RELEASE) $(COMPONENT)' 'Origin: Debian' 'Created-By: Packages' |
    grep ' bookworm' | sort -u
}

# Why none can be made here; nothing where one can.
why_no_bare_debian() {
  if [ "$(id -u)" -ne 0 ]; then
    echo "needs root"
  elif ! command -v mmdebstrap >/dev/null; then
    echo "mmdebstrap is not installed"
  elif [ -z "$(debian_sources)" ]; then
    echo "apt's lists have no Debian 12 (after 'apt-get update' they do, where there is a mirror)"
  fi
}

# make_bare_debian FOLDER: what it installs it takes from where this machine's apt takes it, in the same way (proxies).
make_bare_debian() {
  local log=$1.log
  debian_sources >"$1.list"
  apt-config dump --format '%F "%v";%n' Acquire | grep -E '^Acquire::(http|https|Check-[A-Za-z-]+)[: ]' >"$1.apt" || true
  mmdebstrap --variant=minbase --aptopt="$1.apt" bookworm "$1" "$1.list" >"$log" 2>&1 ||
    { tail -n 20 "$log" >&2; return 1; }
  # Services are not started in it, of whatever package.
  printf '#!/bin/sh\nexit 101\n' >"$1/usr/sbin/policy-rc.d"
  chmod 755 "$1/usr/sbin/policy-rc.d"
  mount --bind /proc "$1/proc"
  mount --rbind --make-rslave /dev "$1/dev"
  in_bare_debian "$1" apt-get update >>"$log" 2>&1
}
unmount_bare_debian() { umount --recursive "$1/dev" "$1/proc"; }
leave_bare_debian() {
  unmount_bare_debian "$1" 2>/dev/null || true
  rm -rf --one-file-system "$1" "$1.log" "$1.list" "$1.apt"
}

# in_bare_debian FOLDER COMMAND [ARGUMENT ...]
in_bare_debian() {
  chroot "$1" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive "${@:2}"
}

# state_of_bare_debian FOLDER: every file with its owner and rights, and who has an account. Not in it: where dpkg and
# apt keep their own books, and the copies that adduser makes of what it changes.
state_of_bare_debian() {
  (cd "$1" && find . -xdev \( -path ./proc -o -path ./dev -o -path ./packages -o -path ./var/lib/dpkg \
    -o -path ./var/lib/apt -o -path ./var/log -o -path ./var/cache -o -path './etc/*-' -o -path ./etc/.pwd.lock \) \
    -prune -o -printf '%p %y %m %U %G %l\n' | sort && cat etc/passwd etc/group etc/shadow etc/gshadow)
}
