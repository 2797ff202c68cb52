#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Runs a command on an LCM bus of its own: a network namespace with nothing but a loopback that takes multicast.
# usage: private_bus.sh COMMAND [ARGUMENT...]. Exit 77 (skipped) where a network namespace may not be made.
set -euo pipefail

if ! unshare -n true 2>/dev/null; then
  echo "skipped: this user may not make a network namespace (unshare -n)"
  exit 77
fi
exec unshare -n bash -c \
  'ip link set lo up multicast on && ip route add 224.0.0.0/4 dev lo && exec "$@"' private_bus "$@"
