#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# silent: a camera over LCM that falls silent 13 times (a busy computer may miss a few): the program closes and opens it
# each time, keeps what it mapped, records what it saw, and ends with exit code 5 when the camera does not come back.
# stopped: the program is stopped while it waits for such a camera, and closes what it recorded all the same.
# odometry: the poses come over LCM, too.
# usage: lcm_camera_test.sh LCM_CAMERA LOOPSIFT silent|stopped|odometry
# To be run by private_bus.sh.
set -euo pipefail

camera=$1 loopsift=$2 part=$3
folder=$(mktemp -d)
camera_pid='' program_pid=''
trap 'kill $camera_pid $program_pid 2>/dev/null || true; rm -rf "$folder"' EXIT

fail() {
  echo "FAILED: $1"
  cat "$folder/log"
  exit 1
}

# start BURSTS FRAMES PAUSE_MS ARGUMENT...: the camera, and the program that looks at it.
start() {
  "$camera" 'udpm://239.255.76.67:7667?ttl=0' "$1" "$2" "$3" &
  camera_pid=$!
  "$loopsift" --source lcm:CAMERA --out "$folder/out" --set lcm_in.open_timeout_s=1 --set source.first_retry_limit=60 \
    --set memory.cap_mib=100000 --set frame.reduction=2 --set fragment.view_step=4 --set fragment.frames_per_fragment=10 \
    --set camera.fx=131.25 --set proposal.enabled=false "${@:4}" >"$folder/log" 2>&1 &
  program_pid=$!
}

# ends_with EXIT_CODE
ends_with() {
  local code=0
  wait "$program_pid" || code=$?
  [[ $code == "$1" ]] || fail "exit code $code, expected $1"
}

figure() {
  python3 -c 'import json, sys
value = json.load(open(sys.argv[1]))
for key in sys.argv[2].split("."): value = value[key]
print(value)' "$folder/out/run.json" "$1"
}

# What the program says when it closes a recording.
recorded_frames() { grep -o "recording.klg: [0-9]* frames" "$folder/log" | grep -o "[0-9]*" || echo 0; }

silent() {
  start 14 15 500 --record "$folder/kept" --set source.stall_periods=8 --set source.retry_limit=4
  ends_with 5
  returns=$(grep -c "the source is open again" "$folder/log") || fail "it never came back"
  [[ $returns -ge 10 ]] || fail "it came back $returns times, of 13"
  [[ $(figure frames.tracked) -ge 100 ]] || fail "too few frames were tracked"
  [[ $(figure memory.heap_calls_after_seal.capture) =~ ^(0|None)$ ]] || fail "the capture thread made heap calls"
  pieces=$(grep -c "starts a new piece" "$folder/log") || fail "no new piece"
  [[ $pieces -ge 10 ]] || fail "$pieces new pieces, of 13"
  recorded=$(recorded_frames)
  [[ $recorded -ge 100 ]] || fail "only $recorded frames were recorded"
  "$loopsift" --source "replay:klg:$folder/kept/recording.klg" --rate max --set lcm.enabled=false \
    --set memory.cap_mib=100000 --set frame.reduction=2 --set fragment.view_step=4 --set proposal.enabled=false \
    --out "$folder/replayed" >"$folder/log" 2>&1 || fail "the recording cannot be replayed"
  echo "13 times silent, back $returns times, $(figure frames.tracked) frames tracked in $pieces further pieces, $recorded recorded"
}

stopped() {
  start 1 30 0 --record "$folder/kept" --set source.stall_periods=60 --set lcm_in.open_timeout_s=60
  for _ in $(seq 1200); do
    grep -q "trying to open it again" "$folder/log" && break
    sleep 0.05
  done
  sleep 0.2 # it listens by now, for a minute
  kill -INT "$program_pid"
  ends_with 0
  recorded=$(recorded_frames)
  [[ $recorded -ge 1 ]] || fail "the recording was not closed"
  echo "stopped while the camera was away: $recorded frames recorded"
}

odometry() {
  start 1 60 0 --odometry lcm:BODY --set source.stall_periods=60 --set source.retry_limit=1
  ends_with 5
  [[ $(figure frames.tracked) -ge 30 ]] || fail "too few frames had a pose over LCM"
  grep -q "poses over LCM" "$folder/log" || fail "nothing was said of the poses"
  echo "odometry over LCM: $(figure frames.tracked) of $(figure frames.received) frames; $(grep -o '[0-9]* poses over LCM.*' "$folder/log")"
}

"$part"
