# SPDX-License-Identifier: MIT
"""Surfels drawn as discs with a z-buffer: which surfel is seen in each pixel, so that one drawing serves every
colouring.

A view is a function that puts surfels on the picture (Spots); splat() finds the nearest disc of each pixel.
"""
import re

import numpy as np

PLY_TYPES = {"char": "i1", "uchar": "u1", "short": "<i2", "ushort": "<u2", "int": "<i4", "uint": "<u4", "float": "<f4",
             "double": "<f8", "int8": "i1", "uint8": "u1", "int16": "<i2", "uint16": "<u2", "int32": "<i4",
             "uint32": "<u4", "float32": "<f4", "float64": "<f8"}
SUPERSAMPLING = 2    # pictures are drawn this much larger, then averaged down
MIN_RADIUS, MAX_RADIUS = 1.5, 14.0  # pixels, of that larger picture
MIN_TOWARD = 0.5  # of a disc's normal: discs seen more aslant are not drawn thinner, so that walls stay closed


class MapError(Exception):
    """A map that cannot be drawn, and why."""


class Surfels:
    """Rows of points (m), unit normals, colours (0 to 1), radii (m); `fragment` and `first_frame_s` where known."""

    def __init__(self, points, normals, colors, radii, fragment=None, first_frame_s=()):
        self.points, self.normals, self.colors, self.radii = points, normals, colors, radii
        self.fragment, self.first_frame_s = fragment, first_frame_s

    def only(self, keep):
        fragment = None if self.fragment is None else self.fragment[keep]
        return Surfels(self.points[keep], self.normals[keep], self.colors[keep], self.radii[keep], fragment,
                       self.first_frame_s)


def read_header(path, file):
    lines = []
    while not lines or lines[-1] != "end_header":
        line = file.readline(1024)
        if not line or (not lines and line.strip() != b"ply"):
            raise MapError(f"{path} is not a PLY file")
        lines.append(line.decode("ascii", "replace").strip())
    if "format binary_little_endian 1.0" not in lines:
        raise MapError(f"{path} is not a binary little-endian PLY")
    return lines


def columns(vertices, names, default):
    if all(name in vertices.dtype.names for name in names):
        return np.stack([vertices[name].astype(np.float32) for name in names], axis=1)
    return np.full((len(vertices), len(names)), default, np.float32)


def fragments_of(header, count):
    """Fragment of each surfel, and when each fragment begins, from the comments of a map.ply; None without them."""
    sizes, starts = [], []
    for line in header:
        match = re.fullmatch(r"comment fragment \d+ surfels (\d+) first_frame_s (\S+)", line)
        if match:
            sizes.append(int(match.group(1)))
            starts.append(float(match.group(2)))
    if sum(sizes) != count:
        return None, ()
    return np.repeat(np.arange(len(sizes)), sizes), np.array(starts)


def read_map(path):
    """The surfels of a map.ply. Grey where the map has no colour."""
    with open(path, "rb") as file:
        header = read_header(path, file)
        elements = "\n".join(header).split("\nelement ")
        vertex = next((e for e in elements if e.startswith("vertex ")), None)
        if vertex is None:
            raise MapError(f"{path} holds no vertices")
        count = int(vertex.split()[1])
        fields = [(name, PLY_TYPES[kind]) for kind, name in re.findall(r"property (\w+) (\w+)", vertex)]
        vertices = np.fromfile(file, dtype=fields, count=count)
    if len(vertices) < count:
        raise MapError(f"{path} is cut short: {len(vertices)} of {count} surfels are there")
    if count == 0:
        raise MapError(f"{path} is an empty map")
    colors = columns(vertices, ["red", "green", "blue"], 190) / 255
    if not colors.any():
        colors[:] = 0.75
    return Surfels(columns(vertices, ["x", "y", "z"], 0), columns(vertices, ["nx", "ny", "nz"], 0), colors,
                   columns(vertices, ["radius"], 0.01)[:, 0], *fragments_of(header, count))


class Spots:
    """Discs on their way into the picture: centre and radius in pixels, depth in metres, normal along the picture's
    right, down and forward (a zero normal faces the picture), and which surfel each is."""

    def __init__(self, u, v, depth, pixels_per_m, radius, normal, surfel):
        order = np.argsort(-np.clip(radius, MIN_RADIUS, MAX_RADIUS), kind="stable")
        self.u, self.v = np.rint(u[order]).astype(np.int32), np.rint(v[order]).astype(np.int32)
        self.depth, self.pixels_per_m = depth[order], pixels_per_m[order]
        self.radius = np.clip(radius[order], MIN_RADIUS, MAX_RADIUS)
        self.normal, self.surfel = normal[order], surfel[order]


def splat(spots, width, height):
    """Index of the surfel seen in each pixel, −1 for none, and its depth. A disc seen aslant is an ellipse whose
    centre is always hit."""
    surfel = np.full((height, width), -1, np.int32)
    nearest = np.full((height, width), np.inf, np.float32)
    if len(spots.radius) == 0:
        return surfel, nearest
    reach = int(np.ceil(spots.radius[0]))
    toward = -np.maximum(np.abs(spots.normal[:, 2]), MIN_TOWARD)
    slope_x, slope_y = -spots.normal[:, 0] / toward, -spots.normal[:, 1] / toward
    for dy in range(-reach, reach + 1):
        for dx in range(-reach, reach + 1):
            large = np.searchsorted(-spots.radius, -np.hypot(dx, dy), side="right")  # these reach that far
            x, y = spots.u[:large] + dx, spots.v[:large] + dy
            dz = slope_x[:large] * dx + slope_y[:large] * dy
            index = np.flatnonzero((spots.radius[:large] ** 2 >= dx * dx + dy * dy + dz * dz) & (x >= 0) & (y >= 0) &
                                   (x < width) & (y < height))
            depth = spots.depth[index] + dz[index] / spots.pixels_per_m[index]
            closer = depth < nearest[y[index], x[index]]
            index, depth = index[closer], depth[closer]
            order = np.argsort(-depth, kind="stable")  # of several in one pixel the last one written stays
            index, depth = index[order], depth[order]
            nearest[y[index], x[index]] = depth
            surfel[y[index], x[index]] = spots.surfel[index]
    return surfel, nearest


def average_down(image):
    n = SUPERSAMPLING
    height, width = image.shape[0] // n * n, image.shape[1] // n * n
    return image[:height, :width].reshape(height // n, n, width // n, n, image.shape[2]).mean(axis=(1, 3))


def camera_axes(forward, up):
    """Rows right, down, forward."""
    forward = forward / np.linalg.norm(forward)
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(forward, right), forward])


def light(normals, to_camera, up):
    """Lambert with a lamp at the camera and one above: how bright each surfel is."""
    facing = np.einsum("ij,ij->i", normals, to_camera)
    return 0.45 + 0.40 * np.clip(facing, 0, 1) + 0.15 * np.clip(normals @ up, 0, 1)


class TopView:
    """From above, orthographic, walls along the picture's edges. Its frame holds the `points` but for a few strays, and
    all of `path` (points; may be empty); the longer side is `size` pixels."""

    def __init__(self, points, path, normals, up, size):
        self.up, self.axes = up, camera_axes(-up, up[[1, 2, 0]])
        wall = normals[np.abs(normals @ up) < 0.2] @ self.axes[:2].T
        turn = np.angle(np.sum((wall[:, 0] + 1j * wall[:, 1]) ** 4)) / 4 if len(wall) else 0.0
        right = np.cos(turn) * self.axes[0] + np.sin(turn) * self.axes[1]
        self.axes = np.stack([right, np.cross(self.axes[2], right), self.axes[2]])
        ends = np.percentile((points @ self.axes.T)[:, :2], (0.2, 99.8), axis=0)
        ends = np.concatenate([ends, (path @ self.axes.T)[:, :2]])
        low, high = ends.min(axis=0), ends.max(axis=0)
        span = high - low
        if span[1] > span[0]:  # the longer side across
            self.axes = np.stack([-self.axes[1], self.axes[0], self.axes[2]])
            low, high = np.array([-high[1], low[0]]), np.array([-low[1], high[0]])
            span = high - low
        self.scale = size * 0.94 / span[0]
        self.width, self.height = size, int(span[1] * self.scale + 0.06 * size)
        self.middle = (low + high) / 2

    def project(self, points):
        p = points @ self.axes.T
        return ((p[:, 0] - self.middle[0]) * self.scale + self.width / 2,
                (p[:, 1] - self.middle[1]) * self.scale + self.height / 2, p[:, 2])

    def see(self, surfels, keep):
        """Surfel indices and brightness of the picture's pixels, at SUPERSAMPLING."""
        n = SUPERSAMPLING
        chosen = np.flatnonzero(keep & (surfels.normals @ self.up > -0.2))
        s = surfels.only(chosen)
        u, v, depth = self.project(s.points)
        scale = np.full(len(chosen), self.scale * n)
        spots = Spots(u * n, v * n, depth, scale, s.radii * scale, s.normals @ self.axes.T, chosen)
        seen, _ = splat(spots, self.width * n, self.height * n)
        return seen, light(surfels.normals, np.broadcast_to(self.up, surfels.points.shape), self.up)


class CameraView:
    """Perspective, from a place that looks along `forward`; horizontal field of view in radians."""

    def __init__(self, eye, forward, up, width, height, field_of_view):
        self.eye, self.up, self.axes = eye, up, camera_axes(forward, up)
        self.width, self.height, self.focal = width, height, 0.5 * width / np.tan(0.5 * field_of_view)

    def project(self, points):
        p = (points - self.eye) @ self.axes.T
        z = np.maximum(p[:, 2], 1e-3)
        return self.focal * p[:, 0] / z + self.width / 2, self.focal * p[:, 1] / z + self.height / 2, p[:, 2]

    def see(self, surfels, keep):
        n = SUPERSAMPLING
        toward = self.eye - surfels.points
        toward = toward / np.maximum(np.linalg.norm(toward, axis=1), 1e-6)[:, None]
        facing = np.einsum("ij,ij->i", surfels.normals, toward) > 0
        u, v, depth = self.project(surfels.points)
        near = (depth > 0.3) & (np.abs(u - self.width / 2) < self.width) & (np.abs(v - self.height / 2) < self.height)
        chosen = np.flatnonzero(keep & facing & near)
        s = surfels.only(chosen)
        pixels_per_m = self.focal * n / depth[chosen]
        spots = Spots(u[chosen] * n, v[chosen] * n, depth[chosen], pixels_per_m, s.radii * pixels_per_m,
                      s.normals @ self.axes.T, chosen)
        seen, _ = splat(spots, self.width * n, self.height * n)
        return seen, light(surfels.normals, toward, self.up)


def paint(seen, brightness, colors):
    """An RGBA picture (0 to 1) of `colors` (per surfel, RGB or RGBA), transparent where nothing is seen."""
    hit = seen >= 0
    rgba = np.zeros(seen.shape + (4,), np.float32)
    surfel = seen[hit]
    alpha = colors[surfel, 3] if colors.shape[1] == 4 else 1.0
    rgba[hit, :3] = np.clip(colors[surfel, :3] * brightness[surfel, None], 0, 1)
    rgba[hit, 3] = alpha
    rgba[..., :3] *= rgba[..., 3:]
    small = average_down(rgba)
    small[..., :3] /= np.maximum(small[..., 3:], 1e-6)
    return small
