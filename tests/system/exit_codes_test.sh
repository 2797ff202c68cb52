#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The exit codes and messages that scripts and service files rely on. Spoiled recordings: bad_input_test.cpp.
# usage: exit_codes_test.sh LOOPSIFT
set -uo pipefail

loopsift=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
failures=0

# expect CODE TEXT ARGUMENT...: runs loopsift; its output must hold TEXT.
expect() {
  local code=$1 text=$2 output got
  shift 2
  output=$("$loopsift" "$@" 2>&1)
  got=$?
  if [[ $got != "$code" || $output != *"$text"* ]]; then
    printf 'loopsift %s: exit %s, expected %s and "%s"; it said:\n%s\n' "$*" "$got" "$code" "$text" "$output"
    failures=$((failures + 1))
  fi
}

printf '[camera]\nfx = "wide"\nmax_depth = 4.0\n' >"$folder/bad.toml"

expect 0 "Sources (URI)" --help
expect 0 "loopsift " --version
expect 0 "cap_mib = 77" --check-config --set memory.cap_mib=77
expect 0 "total" --print-budget --source 'synth:room?frames=2' --set memory.cap_mib=100000
expect 2 "no source"
expect 2 "--sauce" --sauce x
expect 2 "$folder/bad.toml:2: camera.fx" --config "$folder/bad.toml"
expect 2 "nearest is camera.max_depth_m" --config "$folder/bad.toml"
expect 2 "cannot be read" --config "$folder/none.toml"
expect 2 "unknown kind" --source foo:bar
expect 3 "$folder/none" --source "replay:tum:$folder/none"
expect 3 "v4l2:/dev/no-such-node" --source v4l2:/dev/no-such-node
expect 3 "v4l2:/dev/null" --source v4l2:/dev/null
expect 3 "libcamera:no-such-camera" --source libcamera:no-such-camera
expect 3 "lcm:NOBODY" --source lcm:NOBODY --set lcm_in.open_timeout_s=0.1
expect 4 "memory.cap_mib" --source 'synth:room?frames=2' --set memory.cap_mib=1
expect 1 "cannot be made" --source 'synth:room?frames=2' --set lcm.enabled=false --set memory.cap_mib=100000 --out /dev/null/out
exit $((failures > 0))
