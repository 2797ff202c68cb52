# SPDX-License-Identifier: MIT
"""What loopsift publishes, as state: pose with covariance, pose at a time, corrections, loops, health, map.

The same as the C++ header loopsift/client/subscriber.hpp, in small. Transforms are (trans, quat): metres and w, x, y, z;
frames have X forward, Y left, Z up.
"""
import bisect
import math
import secrets
import time

from loopsift_types import Message

CHANNELS = {"LOOPSIFT_POSE": "pose_t", "LOOPSIFT_CORRECTION": "correction_t", "LOOPSIFT_LOOP": "loop_t",
            "LOOPSIFT_HEALTH": "health_t", "LOOPSIFT_FRAGMENT": "fragment_t", "LOOPSIFT_GRAPH": "graph_t",
            "LOOPSIFT_ACK": "ack_t"}
SAVE, PAUSE, RESUME, RESEND, FINISH = 1, 2, 3, 4, 5
GRAPH, LOOPS, STATE = -1, -2, -3
SURFELS, ELEMENTS = 36, 2  # in a chunk: fragment_t.SURFELS_PER_CHUNK, graph_t.ELEMENTS_PER_CHUNK
WINDOW = 256  # chunks in one object of a RESEND
OBJECTS = 32  # of a RESEND


def multiply(a, b):
    return (a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
            a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0])


def compose(a, b):
    """T_a * T_b."""
    conjugate = (a[1][0], -a[1][1], -a[1][2], -a[1][3])
    turned = multiply(multiply(a[1], (0, *b[0])), conjugate)[1:]
    return tuple(p + t for p, t in zip(turned, a[0])), multiply(a[1], b[1])


def interpolate(a, b, s):
    """Between a (s = 0) and b (s = 1); motions between two frames are small: normalised linear in rotation."""
    sign = math.copysign(1, sum(p * q for p, q in zip(a[1], b[1])))
    quat = [(1 - s) * p + s * sign * q for p, q in zip(a[1], b[1])]
    norm = math.sqrt(sum(q * q for q in quat))
    return tuple((1 - s) * p + s * q for p, q in zip(a[0], b[0])), tuple(q / norm for q in quat)


def is_transform(T):
    return all(math.isfinite(v) for v in (*T.trans, *T.quat)) and abs(sum(q * q for q in T.quat) - 1) < 1e-3


def windows(number, chunks):
    """Chunks of an object as what a RESEND asks for: (object, first chunk, bits)."""
    firsts = sorted({k // WINDOW * WINDOW for k in chunks})
    return [(number, first, {k - first for k in chunks if first <= k < first + WINDOW}) for first in firsts]


class Subscriber:
    def __init__(self, bus, types, prefix="", history=1800):
        self.bus, self.types, self.prefix, self.history = bus, types, prefix, history
        self.sender, self.number, self.refused = secrets.randbits(62) | 1, 0, 0
        self.asked = self.map_came = 0.0
        self._reset(0)

    def _reset(self, run):
        self.run, self.poses, self.corrections, self.loops = run, [], [], {}
        self.health, self.answers, self.fragments, self.graph, self.parts = None, {}, {}, {}, (0, {})

    def handle(self, timeout_s):
        """Takes in one message, if one comes. False when none did."""
        received = self.bus.receive(timeout_s)
        if received is None:
            return False
        channel, payload = received
        kind = CHANNELS.get(channel[len(self.prefix):]) if channel.startswith(self.prefix) else None
        if kind:
            try:
                message = self.types.decode("loopsift." + kind, payload)
                getattr(self, "_take_" + kind)(message)
            except ValueError:
                self.refused += 1
        return True

    def pose(self):
        """The newest loopsift.pose_t, or None."""
        return self.poses[-1] if self.poses else None

    def T_map_odom(self):
        if self.corrections:
            T = self.corrections[-1].T_map_odom
            return T.trans, T.quat
        return (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)

    def pose_at(self, utime):
        """T_map_body at a time within the history, in today's map; or None."""
        after = bisect.bisect_left([pose.utime for pose in self.poses], utime)
        if after == len(self.poses) or (after == 0 and self.poses[0].utime != utime):
            return None
        b = self.poses[after]
        T = (b.T_odom_body.trans, b.T_odom_body.quat)
        if b.utime != utime:
            a = self.poses[after - 1]
            T = interpolate((a.T_odom_body.trans, a.T_odom_body.quat), T, (utime - a.utime) / (b.utime - a.utime))
        return compose(self.T_map_odom(), T)

    def map_complete(self):
        def whole(f):
            chunks = self.fragments.get(f)
            return bool(chunks) and len(chunks) == next(iter(chunks.values())).chunk_count
        return bool(self.graph) and all(whole(f) for f in range(len(self.graph["fragments"])))

    def surfels(self):
        """(x, y, z, red, green, blue) of each surfel in map. Pieces that no loop has joined to the map are left out."""
        for f, place in enumerate(self.graph.get("fragments", [])):
            if not place.anchored:
                continue
            R, t = place.R, place.t
            for _, c in sorted(self.fragments.get(f, {}).items()):
                for i in range(c.n):
                    x, y, z = c.x[i], c.y[i], c.z[i]
                    yield (*(R[3 * k] * x + R[3 * k + 1] * y + R[3 * k + 2] * z + t[k] for k in range(3)),
                           c.red[i], c.green[i], c.blue[i])

    def poll(self):
        """Asks for what is missing. Call it often."""
        now = time.monotonic()
        if now - self.asked < 0.1 or (now - self.map_came < 0.08 and now - self.asked < 1.0):
            return
        wanted = self._missing()
        if wanted:
            self.asked = now
            self.send(RESEND, wanted[:OBJECTS])

    def _missing(self):
        wanted = []
        epoch = self.corrections[-1].epoch if self.corrections else 0
        if not self.health or self.health.epoch > epoch or self.health.loops_decided > len(self.loops):
            wanted += [(STATE, 0, set()), (LOOPS, 0, set())]
        newest = self.health.graph_version if self.health else 1
        version, parts = self.parts
        if version < newest:
            wanted.append((GRAPH, 0, set(range(WINDOW))))
        elif parts and len(parts) < next(iter(parts.values())).chunk_count:
            wanted += windows(GRAPH, set(range(next(iter(parts.values())).chunk_count)) - set(parts))
        for f, place in enumerate(self.graph.get("fragments", [])):
            chunks = max(1, -(-place.surfel_count // SURFELS))
            wanted += windows(f, set(range(chunks)) - set(self.fragments.get(f, {})))
        return wanted

    def send(self, command, wanted=()):
        """Sends a command; its number, for self.answers."""
        self.number += 1
        objects = [*wanted, *[(0, 0, set())] * (OBJECTS - len(wanted))]
        message = Message(utime=int(time.time() * 1e6), run=self.run, sender=self.sender, number=self.number,
                          command=command, n_objects=len(wanted), object=[o[0] for o in objects],
                          first_chunk=[o[1] for o in objects],
                          chunks=[[sum(1 << b for b in range(8) if 8 * k + b in o[2]) for k in range(32)]
                                  for o in objects])
        self.bus.send(self.prefix + "LOOPSIFT_COMMAND", self.types.encode("loopsift.command_t", message))
        return self.number

    # What comes in. ValueError: refused.

    def _check(self, good, run):
        if not good or run < self.run or run <= 0:
            raise ValueError("nonsense, or out of date")
        if run > self.run:
            self._reset(run)

    def _take_pose_t(self, m):
        self._check(is_transform(m.T_odom_body) and is_transform(m.T_map_body), m.run)
        if self.poses and m.utime <= self.poses[-1].utime:
            raise ValueError("out of date")
        self.poses = [*self.poses[-self.history:], m]

    def _take_correction_t(self, m):
        self._check(is_transform(m.T_map_odom) and m.epoch > 0, m.run)
        if not self.corrections or m.epoch > self.corrections[-1].epoch:
            self.corrections.append(m)

    def _take_loop_t(self, m):
        self._check(is_transform(m.T_i_j) and m.id >= 0, m.run)
        self.loops[m.id] = m

    def _take_health_t(self, m):
        self._check(m.graph_version >= 0 and m.epoch >= 0, m.run)
        self.health = m

    def _take_ack_t(self, m):
        if m.sender == self.sender:
            self.answers[m.number] = m

    def _take_fragment_t(self, m):
        numbers = (*m.x[:m.n], *m.y[:m.n], *m.z[:m.n]) if 0 <= m.n <= SURFELS else (math.nan,)
        self._check(m.fragment >= 0 and 0 <= m.chunk < m.chunk_count and all(map(math.isfinite, numbers)), m.run)
        self.map_came = time.monotonic()
        self.fragments.setdefault(m.fragment, {})[m.chunk] = m

    def _take_graph_t(self, m):
        self._check(m.version > 0 and 0 <= m.chunk < m.chunk_count and m.version >= self.parts[0] and
                    all(0 <= n <= ELEMENTS for n in (m.n_fragments, m.n_nodes, m.n_edges)), m.run)
        self.map_came = time.monotonic()
        if m.version > self.parts[0]:
            self.parts = (m.version, {})
        parts = self.parts[1]
        parts[m.chunk] = m
        if len(parts) == m.chunk_count:
            chunks = [parts[k] for k in sorted(parts)]
            self.graph = {"version": m.version, "epoch": m.epoch,
                          "fragments": [f for c in chunks for f in c.fragments[:c.n_fragments]],
                          "nodes": [n for c in chunks for n in c.nodes[:c.n_nodes]],
                          "edges": [e for c in chunks for e in c.edges[:c.n_edges]]}
