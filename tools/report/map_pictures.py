# SPDX-License-Identifier: MIT
"""Pictures of the map, before and after, from above and along the path, coloured as seen, by height and by residual."""
import base64
import io

import numpy as np
from PIL import Image

from map_state import before_correction, find_up, pose_at
from surfel_renderer import CameraView, TopView, paint

MAX_SURFELS = 600000
FULL_RESIDUAL_M = 0.10
UNSEEN = np.array([0.60, 0.63, 0.66, 0.40])  # RGBA of what no view was held against
RESIDUAL_STOPS = ((0.0, (0.62, 0.71, 0.77)), (0.25, (0.96, 0.80, 0.42)), (0.55, (0.91, 0.44, 0.20)),
                  (1.0, (0.70, 0.05, 0.27)))
HEIGHT_STOPS = ((0.0, (0.30, 0.27, 0.58)), (0.25, (0.19, 0.46, 0.66)), (0.5, (0.18, 0.66, 0.60)),
                (0.75, (0.58, 0.80, 0.35)), (1.0, (0.98, 0.87, 0.36)))


def blend(stops, share):
    share = np.clip(share, 0, 1)
    at = [s for s, _ in stops]
    return np.stack([np.interp(share, at, [c[k] for _, c in stops]) for k in range(3)], axis=1)


def css_gradient(stops):
    parts = ", ".join(f"rgb({','.join(str(round(255 * v)) for v in color)}) {100 * at:.0f}%" for at, color in stops)
    return f"linear-gradient(90deg, {parts})"


def embedded(rgba):
    """A picture as a data: address."""
    pixels = np.rint(255 * np.clip(rgba, 0, 1)).astype(np.uint8)
    stream = io.BytesIO()
    Image.fromarray(pixels, "RGBA").save(stream, "WEBP", quality=82, method=4)
    return "data:image/webp;base64," + base64.b64encode(stream.getvalue()).decode("ascii")


def path_in(view, positions):
    """The way of the camera as SVG points, in the view's pixels."""
    u, v, _ = view.project(positions)
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in zip(u, v))


class MapState:
    """A map in one state, with what its surfels are coloured by. residual: m, NaN where unknown; or None."""

    def __init__(self, name, surfels, trajectory, up, ceiling, residual):
        self.name, self.surfels, self.trajectory, self.residual = name, surfels, trajectory, residual
        height = surfels.points @ up
        low, high = np.percentile(height, [1, 99])
        self.below_ceiling = height < ceiling
        self.height_range = (low, high)
        self.colors = {"seen": np.clip(surfels.colors, 0, 1) ** 0.7 * 1.05,
                       "height": blend(HEIGHT_STOPS, (height - low) / max(high - low, 1e-6))}
        if residual is not None:
            known = np.isfinite(residual)
            colors = np.tile(UNSEEN, (len(height), 1))
            colors[known, :3] = blend(RESIDUAL_STOPS, residual[known] / FULL_RESIDUAL_M)
            colors[known, 3] = 1
            self.colors["residual"] = colors

    def residual_figures(self):
        """Median and 95th percentile over the surfels that have a residual, m."""
        if self.residual is None or not np.isfinite(self.residual).any():
            return None
        median, p95 = np.nanpercentile(self.residual, [50, 95])
        return {"median_m": float(median), "p95_m": float(p95)}

    def draw(self, view, cut):
        keep = self.below_ceiling if cut else np.ones(len(self.surfels.points), bool)
        seen, brightness = view.see(self.surfels, keep)
        return {name: embedded(paint(seen, brightness, colors)) for name, colors in self.colors.items()}


def thinned(surfels, residual):
    """Every n-th surfel of a very large map, made larger so that it stays closed; and its residuals."""
    step = -(-len(surfels.points) // MAX_SURFELS)
    if step == 1:
        return surfels, residual
    fewer = surfels.only(slice(None, None, step))
    fewer.radii = fewer.radii * np.sqrt(step)
    return fewer, {name: values[::step] for name, values in residual.items()}


def places_along(after, before, count=2):
    """Times of frames in the fragments whose residual fell most; evenly spread where that is not known."""
    surfels = after.surfels
    starts = np.asarray(surfels.first_frame_s)
    times = after.trajectory[:, 0]
    if before is None or before.residual is None or after.residual is None or len(starts) < 2:
        return [times[int(len(times) * share)] for share in (0.25, 0.7)][:count]
    both = np.isfinite(before.residual) & np.isfinite(after.residual)
    gain = np.bincount(surfels.fragment[both], (before.residual - after.residual)[both], len(starts))
    chosen = []
    for k in np.argsort(-gain, kind="stable"):
        if all(abs(k - other) > len(starts) // 6 for other in chosen):
            chosen.append(int(k))
        if len(chosen) == count:
            break
    ends = np.append(starts[1:], times[-1])
    return [0.5 * (starts[k] + ends[k]) for k in sorted(chosen)]


def view_from(trajectory, time_s, up, size):
    """Where the camera was, a step back, a little above, and wider."""
    R, position = pose_at(trajectory, time_s)
    forward = R[:, 2]
    return CameraView(position - 0.7 * forward + 0.25 * up, forward - 0.12 * up, up, size, size * 2 // 3,
                      np.radians(78))


def map_pictures(run, size=860):
    """A list of views, each {title, width, height, states: [{name, pictures: {colouring: address}, path}]}, and what
    else the page says about the map. None without a map."""
    trajectory = run.corrected if run.corrected is not None else run.odometry
    if run.map is None or trajectory is None:
        return None
    surfels, residual = thinned(run.map, run.residual)
    up = find_up(surfels, trajectory)
    height = surfels.points @ up
    over_camera = trajectory[:, 1:4] @ up
    ceiling = max(np.percentile(height, 99.8) - 0.3, np.percentile(over_camera, 50) + 0.1)
    after = MapState("after", surfels, trajectory, up, ceiling, residual.get("after"))
    states = [after]
    if run.odometry is not None and run.corrected is not None:
        moved = before_correction(surfels, run.odometry, run.corrected)
        if moved is not None:
            states.insert(0, MapState("before", moved, run.odometry, up, ceiling, residual.get("before")))
    before = states[0] if len(states) == 2 else None
    top = TopView(np.concatenate([s.surfels.points for s in states]),
                  np.concatenate([s.trajectory[:, 1:4] for s in states]), surfels.normals, up, size)
    views = [{"title": "From above", "width": top.width, "height": top.height,
              "states": [{"name": s.name, "pictures": s.draw(top, True), "path": path_in(top, s.trajectory[:, 1:4])}
                         for s in states]}]
    for time_s in places_along(after, before):
        drawn = [(s, view_from(s.trajectory, time_s, up, size)) for s in states]
        views.append({"title": f"Along the path, at {time_s - trajectory[0, 0]:.1f} s", "width": size,
                      "height": size * 2 // 3,
                      "states": [{"name": s.name, "pictures": s.draw(view, False), "path": ""} for s, view in drawn]})
    return {"views": views, "up": up, "axes": top.axes, "height_range": after.height_range,
            "surfels": len(run.map.points), "residual": {s.name: s.residual_figures() for s in states}}
