# SPDX-License-Identifier: MIT
"""LCM's UDP multicast, for messages below 64 kB (all of loopsift's are).

A datagram: magic LC02, sequence number (4 bytes each), channel name, a zero byte, payload.
"""
import select
import socket
import struct

MAGIC = 0x4C433032


class Bus:
    def __init__(self, group="239.255.76.67", port=7667, ttl=0, receive_buffer=2 << 20):
        self.address, self.sequence = (group, port), 0
        self.ear = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.ear.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.ear.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        self.ear.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
        self.ear.bind((group, port))
        everywhere = struct.pack("4sL", socket.inet_aton(group), socket.INADDR_ANY)
        self.ear.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, everywhere)
        self.mouth = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.mouth.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, ttl)

    def receive(self, timeout_s):
        """(channel, payload), or None when nothing came in time."""
        if not select.select([self.ear], [], [], timeout_s)[0]:
            return None
        datagram = self.ear.recv(65536)
        end = datagram.find(b"\0", 8)
        if len(datagram) < 9 or end < 0 or struct.unpack_from(">I", datagram)[0] != MAGIC:
            return None
        return datagram[8:end].decode(errors="replace"), datagram[end + 1:]

    def send(self, channel, payload):
        head = struct.pack(">II", MAGIC, self.sequence)
        self.sequence = self.sequence + 1 & 0xFFFFFFFF
        self.mouth.sendto(head + channel.encode() + b"\0" + payload, self.address)
