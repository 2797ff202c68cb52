#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Another program proposes loops over LCM while a drifting camera maps: the right one is accepted, the wrong one is
# not, what is no loop is refused. The program's own proposals are off.
# usage: lcm_loop_in_test.sh LCM_LOOP_FINDER LOOPSIFT LOOPSIFT_TOOL
# To be run by private_bus.sh.
set -euo pipefail

finder=$1 loopsift=$2 tool=$3
folder=$(mktemp -d)
trap 'kill "$program_pid" "$finder_pid" 2>/dev/null || true; rm -rf "$folder"' EXIT
url='udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152'
scene='room?width=160&height=120&color=0&rate=5&laps=40' # 39 s each

"$tool" synth "$scene" --no-images --drift 1 --out "$folder" >"$folder/log"
"$finder" "$url" "$folder/groundtruth.txt" 0 40 >"$folder/answers" &
finder_pid=$!
until grep -q listening "$folder/answers"; do sleep 0.05; done
"$loopsift" --source "synth:$scene" --odometry "file:$folder/odometry.txt" --rate max --out "$folder/out" \
  --set frame.reduction=1 --set fragment.frames_per_fragment=20 --set fragment.view_step=4 --set proposal.enabled=false \
  --set store.max_fragments=40 --set memory.cap_mib=100000 >"$folder/log" 2>&1 &
program_pid=$!
code=0
wait "$finder_pid" || code=$?
cat "$folder/answers"
kill -INT "$program_pid" || true
wait "$program_pid" || code=$?
[[ $code == 0 ]] || {
  cat "$folder/log"
  exit 1
}
