#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The Python example decodes what LCM's own code encodes, and refuses the rest."""
import pathlib
import random
import struct
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "subscriber" / "python"))
from loopsift_subscriber import ELEMENTS, SURFELS, Subscriber, windows  # noqa: E402
from loopsift_types import Message, Types  # noqa: E402

TYPES = Types(ROOT / "msgs")
RUN = 1_700_000_000_000_000


def transform(*trans):
    return Message(trans=trans, quat=(1.0, 0.0, 0.0, 0.0))


def pose(utime, x, **changes):
    fields = dict(utime=utime, captured_utime=0, run=RUN, epoch=0, piece=0, anchored=1, T_odom_body=transform(x, 0.0, 0.0), T_map_body=transform(x, 0.0, 0.0),
                  covariance=[0.0] * 36)
    return TYPES.encode("loopsift.pose_t", Message(**{**fields, **changes}))


class FakeBus:
    def __init__(self):
        self.messages, self.sent = [], []

    def receive(self, _):
        return self.messages.pop(0) if self.messages else None

    def send(self, channel, payload):
        self.sent.append((channel, payload))


class TypesTest(unittest.TestCase):
    def test_fingerprints_are_lcms(self):
        # Published with the original type; the generated C++ code has the same.
        self.assertEqual(TYPES.fingerprint("bot_core.pose_t").hex(), "2e16efb052b0105e")

    def test_what_is_encoded_is_decoded(self):
        message = TYPES.decode("loopsift.pose_t", pose(5, 2.5))
        self.assertEqual(message.utime, 5)
        self.assertEqual(message.T_map_body.trans, (2.5, 0.0, 0.0))
        ack = Message(utime=1, run=2, sender=3, number=4, command=5, status=0, message="bien sûr")
        self.assertEqual(TYPES.decode("loopsift.ack_t", TYPES.encode("loopsift.ack_t", ack)).message, "bien sûr")

    def test_constants(self):
        self.assertEqual(TYPES.types["loopsift.command_t"].constants["GRAPH"], -1)
        self.assertEqual(TYPES.types["loopsift.fragment_t"].constants["SURFELS_PER_CHUNK"], SURFELS)
        self.assertEqual(TYPES.types["loopsift.graph_t"].constants["ELEMENTS_PER_CHUNK"], ELEMENTS)

    def test_nonsense_is_a_value_error(self):
        random.seed(2)
        good = pose(5, 2.5)
        text = TYPES.encode("loopsift.ack_t", Message(utime=1, run=2, sender=3, number=4, command=5, status=0, message="x"))
        for _ in range(2000):
            for name, payload in (("loopsift.pose_t", good), ("loopsift.ack_t", text)):
                cut = payload[:random.randrange(len(payload))]
                with self.assertRaises(ValueError):
                    TYPES.decode(name, cut)
                with self.assertRaises(ValueError):
                    TYPES.decode(name, random.randbytes(len(payload)))
        negative = text[:-6] + struct.pack(">i", -5) + text[-2:]
        with self.assertRaises(ValueError):
            TYPES.decode("loopsift.ack_t", negative)


class SubscriberTest(unittest.TestCase):
    def setUp(self):
        self.bus = FakeBus()
        self.subscriber = Subscriber(self.bus, TYPES)

    def feed(self, channel, payload):
        self.bus.messages.append((channel, payload))
        self.subscriber.handle(0)

    def test_pose_at_a_time(self):
        self.feed("LOOPSIFT_POSE", pose(1000, 1.0))
        self.feed("LOOPSIFT_POSE", pose(2000, 3.0))
        self.assertEqual(self.subscriber.pose().utime, 2000)
        self.assertAlmostEqual(self.subscriber.pose_at(1250)[0][0], 1.5)
        self.assertIsNone(self.subscriber.pose_at(999))
        self.assertIsNone(self.subscriber.pose_at(2001))

    def test_refuses_nonsense_and_what_is_out_of_date(self):
        self.feed("LOOPSIFT_POSE", pose(1000, 1.0))
        for payload in (b"", b"xyz", pose(900, 1.0), pose(1100, float("nan")), pose(1100, 1.0, run=RUN - 1)):
            self.feed("LOOPSIFT_POSE", payload)
        self.assertEqual(self.subscriber.refused, 5)
        self.assertEqual(self.subscriber.pose().utime, 1000)
        self.feed("LOOPSIFT_POSE", pose(5, 1.0, run=RUN + 1))
        self.assertEqual(self.subscriber.pose().utime, 5)

    def test_asks_for_what_is_missing(self):
        self.subscriber.poll()
        channel, payload = self.bus.sent[0]
        self.assertEqual(channel, "LOOPSIFT_COMMAND")
        command = TYPES.decode("loopsift.command_t", payload)
        self.assertEqual(command.object[:3], (-3, -2, -1))
        self.assertEqual(command.chunks[2], b"\xff" * 32)

    def test_asks_in_windows(self):
        self.assertEqual(windows(7, {3, 255, 256, 600}), [(7, 0, {3, 255}), (7, 256, {0}), (7, 512, {88})])
        self.assertEqual(windows(7, set()), [])


if __name__ == "__main__":
    unittest.main()
