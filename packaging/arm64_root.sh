# What Debian 12 for arm64 has to compile and link against, unpacked into a folder of its own: nothing of it is installed,
# run or known to this machine's own apt and dpkg. To be sourced after bare_debian.sh and cmake/setup.sh.
# shellcheck shell=bash

# make_arm64_root FOLDER PACKAGE ...: with all that these need. From where this machine's apt takes Debian, in the same way.
# Left as it is where it has been made of the same packages.
make_arm64_root() {
  local root=$1 wanted
  wanted=$(printf '%s\n' "${@:2}" | sort -u)
  [ "$(cat "$root/made_of" 2>/dev/null)" != "$wanted" ] || return 0
  rm -rf --one-file-system "$root"
  mkdir -p "$root"/etc/apt/{apt.conf.d,preferences.d,sources.list.d} "$root"/var/lib/apt/lists/partial \
    "$root"/var/cache/apt/archives/partial "$root"/var/lib/dpkg/{info,updates}
  echo 1 >"$root/var/lib/dpkg/info/format"
  : >"$root/var/lib/dpkg/status"
  debian_sources | sed "s|^deb |deb [signed-by=$keyring] |" >"$root/etc/apt/sources.list"
  configure_arm64_apt "$root"
  apt_of_arm64 "$root" update
  # shellcheck disable=SC2086  # a list of names
  apt_of_arm64 "$root" install --download-only --yes --no-install-recommends $wanted
  local package
  for package in "$root"/var/cache/apt/archives/*.deb; do unpack_into "$root" "$package"; done
  rm -rf "$root"/var/cache/apt/archives/*.deb
  make_links_relative "$root"
  link_alternatives "$root"
  echo "$wanted" >"$root/made_of"
}
readonly keyring=/usr/share/keyrings/debian-archive-keyring.gpg

# Everything that it reads or writes lies in the folder, but for the keys.
configure_arm64_apt() {
  {
    apt-config dump --format '%F "%v";%n' Acquire | grep -E '^Acquire::(http|https|Check-[A-Za-z-]+)[: ]' || true
    cat <<Y
Dir "$1";
Dir::State::status "$1/var/lib/dpkg/status";
APT::Architecture "arm64";
APT::Architectures { "arm64"; };
Debug::NoLocking "true";
APT::Sandbox::User "root";
Y
  } >"$1/etc/apt/arm64.conf"
}
apt_of_arm64() { APT_CONFIG=$1/etc/apt/arm64.conf apt-get --quiet "${@:2}"; }

# As far as dpkg-shlibdeps needs it, dpkg's books tell of it too. Paths are there as they are on this machine, since it
# asks for them as it finds them.
unpack_into() {
  local root=$1 deb=$2 books=$1/var/lib/dpkg name control=$1/control
  dpkg-deb --extract "$deb" "$root"
  dpkg-deb --control "$deb" "$control"
  name=$(dpkg-deb --field "$deb" Package)
  if [ "$(dpkg-deb --field "$deb" Multi-Arch)" = same ]; then name+=:arm64; fi
  dpkg-deb --contents "$deb" | awk -v root="$root" '{ sub(/^\./, root, $6); sub(/\/$/, "", $6); print $6 }' \
    >"$books/info/$name.list"
  local file
  for file in symbols shlibs; do
    [ ! -f "$control/$file" ] || cp "$control/$file" "$books/info/$name.$file"
  done
  { awk '{ print } /^Package:/ { print "Status: install ok installed" }' "$control/control"; echo; } >>"$books/status"
  rm -rf "$control"
}

# Links to /lib/... would lead into this machine's own libraries.
make_links_relative() {
  local link
  find "$1" -xdev -type l -lname '/*' | while read -r link; do
    ln -snf "$(realpath -m --no-symlinks --relative-to="$(dirname "$link")" "$1$(readlink "$link")")" "$link"
  done
}

# What update-alternatives would do on installing: there is one of each.
link_alternatives() {
  local library
  for library in "$1"/usr/lib/aarch64-linux-gnu/{blas/libblas,lapack/liblapack}.so*; do
    [ ! -e "$library" ] || ln -snf "$(basename "$(dirname "$library")")/$(basename "$library")" \
      "$1/usr/lib/aarch64-linux-gnu/$(basename "$library")"
  done
}
