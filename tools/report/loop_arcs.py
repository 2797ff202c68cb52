# SPDX-License-Identifier: MIT
"""The trajectories from above, and the loops as arcs on them; each arc tells its numbers when pointed at."""
from html import escape

import numpy as np

from surfel_renderer import camera_axes

WIDTH, MARGIN = 860, 40
MAX_REFUSED = 400  # arcs drawn of refused loops, best rank first


class Plan:
    """Positions seen from above, fitted to a drawing of WIDTH across."""

    def __init__(self, tracks, up, axes=None):
        self.axes = camera_axes(-up, up[[1, 2, 0]])[:2] if axes is None else axes[:2]
        every = np.concatenate([t @ self.axes.T for t in tracks])
        self.low, high = every.min(axis=0), every.max(axis=0)
        span = np.maximum(high - self.low, 1e-3)
        self.scale = min((WIDTH - 2 * MARGIN) / span[0], 620 / span[1])
        self.offset = np.array([(WIDTH - self.scale * span[0]) / 2, MARGIN])
        self.height = int(span[1] * self.scale + 2 * MARGIN + 16)

    def __call__(self, points):
        return (np.atleast_2d(points) @ self.axes.T - self.low) * self.scale + self.offset

    def line(self, points, css):
        step = max(1, len(points) // 1500)
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in self(points[::step]))
        return f'<polyline class="{css}" points="{path}"/>'

    def scale_bar(self):
        metres = next(m for m in (20, 10, 5, 2, 1, 0.5, 0.2, 0.1, 0.05) if m * self.scale < 0.25 * WIDTH or m == 0.05)
        y, x = self.height - 12, MARGIN
        return (f'<path class="bar" d="M{x},{y - 4}v4h{metres * self.scale:.1f}v-4"/>'
                f'<text x="{x + metres * self.scale + 8:.1f}" y="{y}">{metres:g} m</text>')


def svg(plan, parts, label):
    return (f'<svg class="plan" role="img" aria-label="{escape(label)}" viewBox="0 0 {WIDTH} {plan.height}">'
            + "".join(parts) + plan.scale_bar() + "</svg>")


def trajectories(truth, up, axes):
    """Ground truth and estimates, each aligned to it, in the map's frame. truth: {name: {truth, estimate}}."""
    tracks = {"truth": np.array(next(iter(truth.values()))["truth"])}
    tracks.update({css: np.array(truth[name]["estimate"]) for name, css in (("odometry", "before"),
                                                                          ("corrected", "after")) if name in truth})
    plan = Plan(list(tracks.values()), up, axes)
    return svg(plan, [plan.line(track, css) for css, track in tracks.items()], "Trajectories from above")


def describe(loop):
    words = [f"loop {loop['id']}: fragments {loop['i']} – {loop['j']}", f"{loop['decision']}: {loop['reason']}"]
    if loop["rank"] >= 0:
        words.append(f"rank {loop['rank']}")
    for key, name in (("single_dmp", "score alone"), ("tested_dmp", "score when tested"),
                      ("best_dmp_before", "best before")):
        if loop[key] is not None:
            words.append(f"{name} {loop[key]:.6g}")
    if loop.get("error_m") is not None:
        words.append(f"off the truth by {100 * loop['error_m']:.1f} cm, {loop['error_deg']:.1f}°")
    return "\n".join(words)


def arc(a, b, bulge):
    """A quadratic curve from a to b that leaves the straight line to one side."""
    middle, along = (a + b) / 2, b - a
    control = middle + bulge * np.array([along[1], -along[0]])
    return f"M{a[0]:.1f},{a[1]:.1f}Q{control[0]:.1f},{control[1]:.1f} {b[0]:.1f},{b[1]:.1f}"


def loop_arcs(run, up, axes):
    """None where trajectory, loops or the times of the fragments are not there."""
    trajectory = run.corrected if run.corrected is not None else run.odometry
    starts = () if run.map is None else run.map.first_frame_s
    if trajectory is None or not run.loops or len(starts) == 0:
        return None
    plan = Plan([trajectory[:, 1:4]], up, axes)
    ends = np.append(starts[1:], trajectory[-1, 0])
    middles = [np.argmin(np.abs(trajectory[:, 0] - 0.5 * (a + b))) for a, b in zip(starts, ends)]
    where = plan(trajectory[middles, 1:4])
    refused = [x for x in run.loops if x["decision"] != "accepted"]
    refused.sort(key=lambda x: (x["rank"] < 0, x["rank"]))
    accepted = [x for x in run.loops if x["decision"] == "accepted"]
    parts = [plan.line(trajectory[:, 1:4], "track")]
    for loop in refused[:MAX_REFUSED][::-1] + accepted:
        if not (0 <= loop["i"] < len(where) and 0 <= loop["j"] < len(where)):
            continue
        kind = "accepted" if loop["decision"] == "accepted" else "refused"
        wrong = " wrong" if kind == "accepted" and loop.get("correct") is False else ""
        parts.append(f'<path class="arc {kind}{wrong}" d="{arc(where[loop["i"]], where[loop["j"]], 0.28)}">'
                     f"<title>{escape(describe(loop))}</title></path>")
    for k, (x, y) in enumerate(where):
        parts.append(f'<circle class="node" cx="{x:.1f}" cy="{y:.1f}" r="3.2"><title>fragment {k}</title></circle>')
    return svg(plan, parts, "Loops on the trajectory")
