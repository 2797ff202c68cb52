#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs everything that loopsift is built, tested and checked with, on Debian 12 or a later Debian or Ubuntu.
# Works as root and with sudo. Does nothing when all is there.
set -euo pipefail

packages=(
  # build
  build-essential cmake ninja-build ccache pkg-config git
  # libraries
  libeigen3-dev libceres-dev libembree-dev libnanoflann-dev
  libjpeg-dev libpng-dev libturbojpeg0-dev zlib1g-dev
  liblcm-dev liblcm-bin libglib2.0-dev libopenni2-dev
  libcamera-dev
  libtomlplusplus-dev libcli11-dev libspdlog-dev nlohmann-json3-dev
  # tests, benchmarks and checks
  libgtest-dev libgmock-dev libbenchmark-dev
  clang-14 clang-format clang-tidy libomp-14-dev libclang-rt-14-dev
  iproute2 nftables util-linux
  # pictures of maps, reports
  python3 python3-numpy python3-pil python3-matplotlib
)

missing=()
for package in "${packages[@]}"; do
  [[ $(dpkg-query -W -f='${Status}' "$package" 2>/dev/null) == "install ok installed" ]] || missing+=("$package")
done
if ((${#missing[@]} == 0)); then
  echo "dependencies: all installed"
  exit 0
fi

run=()
if ((EUID != 0)); then
  command -v sudo >/dev/null || { echo "install_dependencies.sh: needs root; install sudo or run as root" >&2; exit 1; }
  run=(sudo)
fi
apt_get=("${run[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=400 -q)
echo "dependencies: installing ${missing[*]}"
"${apt_get[@]}" update
"${apt_get[@]}" install -y --no-install-recommends "${missing[@]}"
