#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Fuzzes the parsers of foreign input with clang's libFuzzer, under the address and undefined-behaviour sanitizers. The
# corpus is made from a rendered room and the settings files; what is found lies in build/fuzz/found, and the exit code is 1.
# usage: fuzz.sh [SECONDS_EACH [FUZZER...]]     default 60, all
set -euo pipefail
cd "$(dirname "$0")/../.."

seconds=${1:-60}
fuzzers=("${@:2}")
((${#fuzzers[@]})) || fuzzers=(fuzz_klg fuzz_png16 fuzz_color fuzz_images fuzz_config)

cmake --preset fuzz
cmake --build --preset fuzz
corpus=build/fuzz/corpus
found=build/fuzz/found
TIMEFORMAT='%U s of processor time, %S s in the kernel'
mkdir -p "$corpus/fuzz_config" "$found"
build/fuzz/tests/fuzz/make_corpus "$corpus"
cp config/*.toml config/cameras/*.toml "$corpus/fuzz_config/"
failures=0
for fuzzer in "${fuzzers[@]}"; do
  echo "== $fuzzer"
  time "build/fuzz/tests/fuzz/$fuzzer" "$corpus/$fuzzer" -artifact_prefix="$found/$fuzzer-" -max_total_time="$seconds" \
    -max_len=20000 -timeout=60 -rss_limit_mb=2048 -print_final_stats=1 -verbosity=0 2>&1 | tail -n 12 || failures=1
done
exit "$failures"
