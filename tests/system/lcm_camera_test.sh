#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# A camera over LCM that falls silent 13 times (a busy computer may miss a few): the program closes and opens it each
# time, keeps what it mapped, records what it saw, and ends with exit code 5 when the camera does not come back. Then
# odometry over LCM.
# usage: lcm_camera_test.sh LCM_CAMERA LOOPSIFT
# To be run by private_bus.sh.
set -euo pipefail

camera=$1 loopsift=$2
folder=$(mktemp -d)
trap 'kill "$camera_pid" 2>/dev/null || true; rm -rf "$folder"' EXIT

fail() {
  echo "FAILED: $1"
  cat "$folder/log"
  exit 1
}

# run BURSTS FRAMES PAUSE_MS EXPECTED_EXIT_CODE ARGUMENT...
run() {
  local bursts=$1 frames=$2 pause_ms=$3 expected=$4 code=0
  shift 4
  rm -rf "$folder/out"
  "$camera" 'udpm://239.255.76.67:7667?ttl=0' "$bursts" "$frames" "$pause_ms" &
  camera_pid=$!
  "$loopsift" --source lcm:CAMERA --out "$folder/out" --set lcm_in.open_timeout_s=60 --set memory.cap_mib=100000 \
    --set frame.reduction=2 --set fragment.view_step=4 --set fragment.frames_per_fragment=10 --set camera.fx=131.25 \
    --set proposal.enabled=false "$@" >"$folder/log" 2>&1 || code=$?
  [[ $code == "$expected" ]] || fail "exit code $code, expected $expected"
}

figure() {
  python3 -c 'import json, sys
value = json.load(open(sys.argv[1]))
for key in sys.argv[2].split("."): value = value[key]
print(value)' "$folder/out/run.json" "$1"
}

run 14 20 1000 5 --record "$folder/kept" --set source.stall_periods=10 --set source.retry_limit=2 --set lcm_in.open_timeout_s=4
returns=$(grep -c "the source is open again" "$folder/log") || fail "it never came back"
[[ $returns -ge 10 ]] || fail "it came back $returns times, of 13"
[[ $(figure frames.tracked) -ge 100 ]] || fail "too few frames were tracked"
[[ $(figure memory.heap_calls_after_seal.capture) =~ ^(0|None)$ ]] || fail "the capture thread made heap calls"
pieces=$(grep -c "starts a new piece" "$folder/log") || fail "no new piece"
[[ $pieces -ge 10 ]] || fail "$pieces new pieces, of 13"
recorded=$(grep -o "recording.klg: [0-9]* frames" "$folder/log" | grep -o "[0-9]*") || fail "nothing was recorded"
[[ $recorded -ge 100 ]] || fail "only $recorded frames were recorded"
"$loopsift" --source "replay:klg:$folder/kept/recording.klg" --rate max --set lcm.enabled=false --set memory.cap_mib=100000 \
  --set frame.reduction=2 --set fragment.view_step=4 --out "$folder/replayed" >"$folder/log" 2>&1 || fail "the recording cannot be replayed"
echo "13 times silent, back $returns times, $(figure frames.tracked) frames tracked in $pieces further pieces, $recorded recorded"

run 1 60 0 5 --odometry lcm:BODY --set source.stall_periods=60 --set source.retry_limit=1 --set lcm_in.open_timeout_s=5
[[ $(figure frames.tracked) -ge 30 ]] || fail "too few frames had a pose over LCM"
grep -q "poses over LCM" "$folder/log" || fail "nothing was said of the poses"
echo "odometry over LCM: $(figure frames.tracked) of $(figure frames.received) frames; $(grep -o '[0-9]* poses over LCM.*' "$folder/log")"
