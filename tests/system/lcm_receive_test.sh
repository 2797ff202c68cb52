#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Runs a program and a subscriber as two processes on a loopback bus of their own and compares what arrived.
# usage: lcm_receive_test.sh LISTENER "CHANNEL=COUNT ..." PROGRAM [ARGUMENT...]
# COUNT is a number, or + for at least one. To be run by private_bus.sh.
set -euo pipefail

listener=$1 expected=$2
shift 2
folder=$(mktemp -d)
trap 'kill "$listener_pid" 2>/dev/null || true; rm -rf "$folder"' EXIT
"$listener" 'udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152' >"$folder/heard" &
listener_pid=$!
for _ in $(seq 600); do
  grep -q listening "$folder/heard" && break
  sleep 0.1
done

"$@"
kill -TERM "$listener_pid"
wait "$listener_pid"
cat "$folder/heard"

sed 1d "$folder/heard" | python3 -c '
import json, sys
heard = json.load(sys.stdin)
wrong = []
for expectation in sys.argv[1].split():
    channel, expected = expectation.split("=")
    got = heard.get(channel, {"count": 0, "bad": 0, "out_of_order": 0})
    if got["count"] == 0 or (expected != "+" and got["count"] != int(expected)):
        wrong.append("{}: {count} messages, expected {}".format(channel, expected, **got))
    if got["bad"] or got["out_of_order"]:
        wrong.append("{}: {bad} bad, {out_of_order} out of order".format(channel, **got))
sys.exit("\n".join(wrong) or 0)
' "$expected"
