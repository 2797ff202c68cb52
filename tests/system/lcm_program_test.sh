#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The program while it maps: a subscriber joins late, has it pause, save and finish, and must have rebuilt the map that was
# saved, byte for byte. usage: lcm_program_test.sh JOINER PROGRAM [ARGUMENT...]; --out is added.
# To be run by private_bus.sh.
set -euo pipefail

joiner=$1
shift
folder=$(mktemp -d)
trap 'kill "$program_pid" 2>/dev/null || true; rm -rf "$folder"' EXIT
"$@" --out "$folder/out" 2>"$folder/log" &
program_pid=$!
"$joiner" 'udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152' "$folder/rebuilt.ply" 60 1000 || {
  cat "$folder/log"
  exit 1
}
wait "$program_pid" # exit 0: it was told to finish
cmp "$folder/rebuilt.ply" "$folder/out/saved/map.ply"
[[ -s $folder/out/run.json ]]
echo "the rebuilt map is the saved one: $(stat -c %s "$folder/rebuilt.ply") bytes"
