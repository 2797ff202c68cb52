#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The V4L2 and libcamera drivers against real kernel devices, with no hardware: a virtual machine (emulated, no
# rights needed) runs Debian's own kernel with its test cameras vivid, v4l2loopback and vimc, and guest_check.
#   run_guest.sh BUILD_DIR [WORK_DIR]
# WORK_DIR (default: $XDG_CACHE_HOME/loopsift-guest) keeps the downloaded packages and the modules built from them:
# 220 MB to fetch and 2 GB on disk the first time, which takes some minutes; a later run takes about a minute. The
# log goes to the terminal and to WORK_DIR/guest.log. Exit code 0: all checks passed; 77: something needed is missing.
set -euo pipefail

here=$(cd "$(dirname "$0")" && pwd)
build=$(cd "${1:?usage: run_guest.sh BUILD_DIR [WORK_DIR]}" && pwd)
mkdir -p "${2:-${XDG_CACHE_HOME:-$HOME/.cache}/loopsift-guest}"
work=$(cd "${2:-${XDG_CACHE_HOME:-$HOME/.cache}/loopsift-guest}" && pwd)
check=$build/tests/system/guest/guest_check
limit_s=${LOOPSIFT_GUEST_LIMIT_S:-600}

need() { command -v "$1" >/dev/null || { echo "run_guest.sh: $1 is missing; apt-get install $2" >&2; exit 77; }; }
need qemu-system-x86_64 qemu-system-x86
need apt-get apt
need make build-essential
need cpio cpio
[[ -x $check ]] || { echo "run_guest.sh: $check is missing; build the target guest_check" >&2; exit 77; }

# The kernel that Debian's linux-image-amd64 stands for, its headers, and what else the guest is made of.
fetch() {
  kernel=$(apt-cache depends linux-image-amd64 | sed -n 's/.*Depends: linux-image-\([0-9].*\)/\1/p' | head -n 1)
  [[ -n $kernel ]] || { echo "run_guest.sh: apt knows no linux-image-amd64; run apt-get update" >&2; exit 77; }
  root=$work/$kernel
  [[ -e $root/fetched ]] && return
  mkdir -p "$root/packages"
  local series=${kernel%.*}
  (cd "$root/packages" && apt-get -q download "linux-image-$kernel" "linux-headers-$kernel" \
    "linux-headers-${kernel%-amd64}-common" "linux-kbuild-$series" "linux-source-$series" v4l2loopback-dkms \
    busybox-static libcamera-ipa udev)
  for package in "$root"/packages/*.deb; do dpkg-deb -x "$package" "$root"; done
  mkdir -p "$root/vimc"
  tar -C "$root/vimc" --strip-components=5 -xJf "$root/usr/src/linux-source-$series.tar.xz" \
    "linux-source-$series/drivers/media/test-drivers/vimc"
  touch "$root/fetched"
}

# Debian's kernel comes with vivid, but with neither of these.
build_modules() {
  [[ -e $root/built ]] && return
  local headers=$root/usr/src/linux-headers-$kernel loopback
  loopback=$(echo "$root"/usr/src/v4l2loopback-*)
  sed -i "s#^include /usr/src/#include $root/usr/src/#" "$headers/Makefile"
  make -s -C "$headers" M="$loopback" modules
  make -s -C "$headers" M="$root/vimc" CONFIG_VIDEO_VIMC=m modules
  cp "$loopback"/*.ko "$root"/vimc/*.ko "$root/lib/modules/$kernel/"
  touch "$root/built"
}

# Copies a program or library with all the libraries that it is linked to.
with_libraries() {
  install -D "$1" "$image/$2"
  ldd "$1" | sed -n 's/.*=> \(\/[^ ]*\).*/\1/p; s/^\s*\(\/[^ ]*ld-linux[^ ]*\).*/\1/p' | while read -r library; do
    [[ -e $image/$library ]] || install -D "$library" "$image/$library"
  done
}

make_image() {
  image=$root/image
  rm -rf "$image"
  mkdir -p "$image"/{bin,proc,sys,dev,run,tmp,etc,lib/systemd,lib/udev}
  install "$root/bin/busybox" "$image/bin/busybox"
  install "$here/init" "$image/init"
  with_libraries "$check" bin/guest_check
  with_libraries "$root/bin/udevadm" bin/udevadm
  ln -s /bin/udevadm "$image/lib/systemd/systemd-udevd"
  cp -r "$root/lib/udev/rules.d" "$image/lib/udev/"
  local ipa=usr/lib/x86_64-linux-gnu/libcamera
  mkdir -p "$image/$ipa" "$image/usr/share/libcamera/ipa"
  cp "$root/$ipa"/ipa_vimc.so* "$image/$ipa/"
  cp -r "$root/usr/share/libcamera/ipa/vimc" "$image/usr/share/libcamera/ipa/"
  local modules=$image/lib/modules/$kernel
  mkdir -p "$modules/kernel/drivers"
  cp "$root/lib/modules/$kernel"/*.ko "$root/lib/modules/$kernel"/modules.{builtin,order} "$modules/"
  cp -r "$root/lib/modules/$kernel/kernel/drivers/media" "$modules/kernel/drivers/"
  find "$modules/kernel/drivers/media" -mindepth 1 -maxdepth 1 \
    ! -name common ! -name mc ! -name v4l2-core ! -name cec ! -name rc ! -name test-drivers -exec rm -r {} +
  (cd "$image" && find . | cpio --quiet -o -H newc | gzip -1) >"$root/image.gz"
}

run() {
  timeout "$limit_s" qemu-system-x86_64 -accel tcg -cpu max -smp 2 -m 1024 -nographic -no-reboot -nic none \
    -kernel "$root/boot/vmlinuz-$kernel" -initrd "$root/image.gz" \
    -append "console=ttyS0 quiet panic=-1" </dev/null | tr -d '\r' | tee "$work/guest.log"
  grep -q '^== guest: all checks passed$' "$work/guest.log"
}

fetch
build_modules
make_image
run
