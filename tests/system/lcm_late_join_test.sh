#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# A subscriber joins a publisher with a finished map over a network that loses packets, and must end up with the same
# map, byte for byte; malformed commands change nothing. The two run in network namespaces of their own, joined by a
# cable (veth, 1500 bytes a packet) at whose ends nftables drops LOSS_PERCENT of all packets.
# usage: lcm_late_join_test.sh SERVER JOINER FRAGMENTS LOSS_PERCENT LIMIT_S MALFORMED
# To be run by private_bus.sh. Exit 77 (skipped) where the kernel or nftables cannot do it.
set -euo pipefail

server=$1 joiner=$2 fragments=$3 loss=$4 limit_s=$5 malformed=$6
folder=$(mktemp -d)
far_pid='' server_pid=''
trap 'kill $server_pid $far_pid 2>/dev/null || true; rm -rf "$folder"' EXIT

skip() {
  echo "skipped: $1"
  exit 77
}

# The namespace of the one who joins lives as long as this process.
unshare -n sleep infinity &
far_pid=$!
until [[ $(readlink "/proc/$far_pid/ns/net") != $(readlink /proc/self/ns/net) ]]; do sleep 0.01; done
far() { nsenter --net --target "$far_pid" "$@"; }

# lossy_end DEVICE OWN OTHER, after `far` or after nothing: an end of the cable that loses what the other one sends.
lossy_end() {
  "${@:4}" ip address add "$2/30" dev "$1"
  "${@:4}" ip link set "$1" up multicast on mtu 1500
  "${@:4}" ip route replace 224.0.0.0/4 dev "$1"
  "${@:4}" nft "add table ip bad; add chain ip bad cable { type filter hook prerouting priority -450; };
    add rule ip bad cable ip saddr $3 counter; add rule ip bad cable ip saddr $3 numgen random mod 100 < $loss counter drop"
}
command -v nft >/dev/null || skip "nftables is not installed"
ip link add cable type veth peer name cable netns "$far_pid" || skip "no virtual network cable (veth)"
lossy_end cable 10.7.7.1 10.7.7.2 || skip "nftables cannot drop packets at random here"
lossy_end cable 10.7.7.2 10.7.7.1 far

# lost_packets [far]: what was dropped at one end, of what arrived there.
lost_packets() { "$@" nft list chain ip bad cable | grep -o 'packets [0-9]*' | tr -dc '0-9\n' | tac | paste -sd' '; }

url='udpm://239.255.76.67:7667?ttl=1'
"$server" "$url" "$fragments" "$folder/saved.ply" >"$folder/server" &
server_pid=$!
for _ in $(seq 1200); do
  grep -qs listening "$folder/server" && break
  sleep 0.05
done
sleep 2 # what the publisher sends by itself goes by unheard

far "$joiner" "$url&recv_buf_size=2097152" "$folder/rebuilt.ply" "$limit_s" "$malformed"
wait "$server_pid" || true
server_pid=''
grep -v listening "$folder/server" || true
echo "lost of IP packets: $(lost_packets far | sed 's/ / of /') to the subscriber, $(lost_packets | sed 's/ / of /') from it"
cmp "$folder/rebuilt.ply" "$folder/saved.ply"
echo "the rebuilt map is the saved one: $(stat -c %s "$folder/saved.ply") bytes"
