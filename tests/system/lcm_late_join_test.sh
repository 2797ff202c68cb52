#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# A subscriber joins a publisher with a finished map over a bus that loses packets, and must end up with the same map,
# byte for byte; malformed commands change nothing. usage:
# lcm_late_join_test.sh SERVER RELAY JOINER FRAGMENTS LOSS LIMIT_S MALFORMED
# To be run by private_bus.sh.
set -euo pipefail

server=$1 relay=$2 joiner=$3 fragments=$4 loss=$5 limit_s=$6 malformed=$7
folder=$(mktemp -d)
trap 'kill "$server_pid" "$relay_pid" 2>/dev/null || true; rm -rf "$folder"' EXIT
wait_for() {
  for _ in $(seq 1200); do
    grep -q listening "$1" && return
    sleep 0.05
  done
}
"$relay" 7667 7668 "$loss" >"$folder/relay" &
relay_pid=$!
"$server" 'udpm://239.255.76.67:7667?ttl=0' "$fragments" "$folder/saved.ply" >"$folder/server" &
server_pid=$!
wait_for "$folder/relay"
wait_for "$folder/server"
sleep 2 # what the publisher sends by itself goes by unheard

"$joiner" 'udpm://239.255.76.67:7668?ttl=0&recv_buf_size=2097152' "$folder/rebuilt.ply" "$limit_s" "$malformed"
wait "$server_pid" || true
kill -TERM "$relay_pid"
wait "$relay_pid" || true
cat "$folder/server" "$folder/relay" | grep -v listening
cmp "$folder/rebuilt.ply" "$folder/saved.ply"
echo "the rebuilt map is the saved one: $(stat -c %s "$folder/saved.ply") bytes"
