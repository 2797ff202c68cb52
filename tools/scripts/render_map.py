#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Pictures of a map.ply: OUT_top.png from above (orthographic) and OUT_view.png from a raised corner (perspective).

Surfels are drawn as discs, nearest wins, colour shaded by the normal against two lamps. Surfels that face away are
left out: one looks into a room through the backs of its walls and ceiling. The floor is taken to be level with the
first camera: up is -y of the map unless --up says otherwise. With --trajectory, the camera's way is drawn from yellow
(start) to red (end). Colours are reduced to 256, which keeps the files small.
"""
import argparse
import re
import sys

import numpy as np
from PIL import Image

PLY_TYPES = {"char": "i1", "uchar": "u1", "short": "<i2", "ushort": "<u2", "int": "<i4", "uint": "<u4", "float": "<f4",
             "double": "<f8", "int8": "i1", "uint8": "u1", "int16": "<i2", "uint16": "<u2", "int32": "<i4",
             "uint32": "<u4", "float32": "<f4", "float64": "<f8"}
BACKGROUND = 1.0
SUPERSAMPLING = 2    # pictures are drawn this much larger, then averaged down
MIN_RADIUS, MAX_RADIUS = 1.5, 14.0  # pixels, of that larger picture
MIN_TOWARD = 0.5  # of a disc's normal: discs seen more aslant are not drawn thinner, so that walls stay closed
PATH_RADIUS = 3.0
PATH_ENDS = np.array([[1.0, 0.80, 0.10], [0.85, 0.10, 0.15]])


def read_ply(path):
    """The vertices of a binary little-endian PLY as a structured array."""
    with open(path, "rb") as file:
        head = file.read(4096)
        end = head.find(b"end_header\n")
        if not head.startswith(b"ply") or end < 0 or b"format binary_little_endian" not in head[:end]:
            sys.exit(f"render_map.py: {path} is not a binary little-endian PLY")
        header = head[:end].decode("ascii", "replace")
        count = int(re.search(r"element vertex (\d+)", header).group(1))
        vertex = re.split(r"element ", header)[1]
        fields = [(name, PLY_TYPES[kind]) for kind, name in re.findall(r"property (\w+) (\w+)", vertex)]
        file.seek(end + len(b"end_header\n"))
        vertices = np.fromfile(file, dtype=fields, count=count)
    if len(vertices) < count or count == 0:
        sys.exit(f"render_map.py: {path} holds {len(vertices)} of {count} vertices")
    return vertices


def columns(vertices, names, default):
    if all(name in vertices.dtype.names for name in names):
        return np.stack([vertices[name].astype(np.float32) for name in names], axis=1)
    return np.full((len(vertices), len(names)), default, np.float32)


class Surfels:
    def __init__(self, points, normals, colors, radii):
        self.points, self.normals, self.colors, self.radii = points, normals, colors, radii

    def only(self, keep):
        return Surfels(self.points[keep], self.normals[keep], self.colors[keep], self.radii[keep])


def read_map(path, up, cut):
    """The surfels without the highest `cut` metres, grey where the map has no colour."""
    vertices = read_ply(path)
    surfels = Surfels(columns(vertices, ["x", "y", "z"], 0), columns(vertices, ["nx", "ny", "nz"], 0),
                      columns(vertices, ["red", "green", "blue"], 190) / 255, columns(vertices, ["radius"], 0.01)[:, 0])
    if not surfels.colors.any():
        surfels.colors[:] = 0.75
    height = surfels.points @ up
    return surfels.only(height <= np.percentile(height, 99.8) - cut) if cut > 0 else surfels


def path_surfels(path, spacing):
    """A string of beads along a TUM trajectory."""
    points = np.loadtxt(path, usecols=(1, 2, 3), dtype=np.float32, ndmin=2)
    along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    beads = np.arange(0, along[-1], spacing)
    points = np.stack([np.interp(beads, along, points[:, k]) for k in range(3)], axis=1).astype(np.float32)
    share = (beads / max(along[-1], 1e-9))[:, None]
    colors = ((1 - share) * PATH_ENDS[0] + share * PATH_ENDS[1]).astype(np.float32)
    return Surfels(points, np.zeros_like(points), colors, np.zeros(len(points), np.float32))


def camera_axes(forward, up):
    """Rows right, down, forward."""
    forward = forward / np.linalg.norm(forward)
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(forward, right), forward])


class Spots:
    """Discs on their way into the picture: centre and radius in pixels, depth in metres, normal along the picture's
    right, down and forward. A zero normal faces the picture."""

    def __init__(self, u, v, depth, pixels_per_m, radius, normal, color):
        self.u, self.v, self.depth, self.pixels_per_m = u, v, depth, pixels_per_m
        self.radius, self.normal, self.color = np.clip(radius, MIN_RADIUS, MAX_RADIUS), normal, color


def draw(image, nearest, spots):
    """Into the image, nearest first, against `nearest` too; a disc seen aslant is an ellipse, its centre always hit."""
    height, width = nearest.shape
    reach = int(np.ceil(spots.radius.max())) if len(spots.radius) else 0
    u, v = np.rint(spots.u).astype(int), np.rint(spots.v).astype(int)
    toward = -np.maximum(np.abs(spots.normal[:, 2]), MIN_TOWARD)
    slope_x, slope_y = -spots.normal[:, 0] / toward, -spots.normal[:, 1] / toward
    for dy in range(-reach, reach + 1):
        for dx in range(-reach, reach + 1):
            x, y = u + dx, v + dy
            dz = slope_x * dx + slope_y * dy
            hit = (spots.radius ** 2 >= dx * dx + dy * dy + dz * dz) & (x >= 0) & (y >= 0) & (x < width) & (y < height)
            index = np.flatnonzero(hit)
            depth = spots.depth[index] + dz[index] / spots.pixels_per_m[index]
            order = np.argsort(-depth)  # of several in one pixel the last one written stays
            order = order[depth[order] < nearest[y[index[order]], x[index[order]]]]
            index, depth = index[order], depth[order]
            nearest[y[index], x[index]] = depth
            image[y[index], x[index]] = spots.color[index]


def shade(surfels, to_camera, up):
    """Lambert with a lamp at the camera and one above, brightened for white paper."""
    facing = np.einsum("ij,ij->i", surfels.normals, to_camera)
    light = 0.45 + 0.40 * np.clip(facing, 0, 1) + 0.15 * np.clip(surfels.normals @ up, 0, 1)
    return np.clip(surfels.colors, 0, 1) ** 0.7 * light[:, None]


def crop(image, nearest, margin):
    """What is drawn and a margin around it."""
    rows, cols = np.flatnonzero(np.isfinite(nearest).any(axis=1)), np.flatnonzero(np.isfinite(nearest).any(axis=0))
    if len(rows) == 0:
        return image
    inside = image[rows[0]:rows[-1] + 1, cols[0]:cols[-1] + 1]
    return np.pad(inside, ((margin, margin), (margin, margin), (0, 0)), constant_values=BACKGROUND)


def average_down(image):
    n = SUPERSAMPLING
    height, width = image.shape[0] // n * n, image.shape[1] // n * n
    return image[:height, :width].reshape(height // n, n, width // n, n, 3).mean(axis=(1, 3))


def render(layers, width, height):
    image = np.full((height, width, 3), BACKGROUND, np.float32)
    nearest = np.full((height, width), np.inf, np.float32)
    for spots in layers:
        draw(image, nearest, spots)
    return average_down(crop(image, nearest, 16 * SUPERSAMPLING))


def top_view(surfels, path, up, size):
    axes = camera_axes(-up, up[[1, 2, 0]])
    size *= SUPERSAMPLING
    low, high = (np.percentile(surfels.points @ axes.T, q, axis=0) for q in (0.1, 99.9))
    if path is not None:
        way = path.points @ axes.T
        low, high = np.minimum(low, way.min(axis=0)), np.maximum(high, way.max(axis=0))
    scale = size * 0.97 / max(high[0] - low[0], high[1] - low[1])
    width, height = (int((high[k] - low[k]) * scale / 0.97) + 1 for k in (0, 1))

    def spots(s, radius, color, raised_m=0.0):
        p = s.points @ axes.T
        return Spots((p[:, 0] - (low[0] + high[0]) / 2) * scale + width / 2,
                     (p[:, 1] - (low[1] + high[1]) / 2) * scale + height / 2, p[:, 2] - raised_m,
                     np.full(len(p), scale), radius, s.normals @ axes.T, color)

    seen = surfels.only(surfels.normals @ up > -0.2)
    layers = [spots(seen, seen.radii * scale, shade(seen, np.broadcast_to(up, seen.points.shape), up))]
    if path is not None:  # raised: the way is not hidden by what hangs over it
        layers.append(spots(path, np.full(len(path.points), PATH_RADIUS), path.colors, high[2] - low[2]))
    return render(layers, width, height)


def corner_view(surfels, path, up, size, turn_deg, tilt):
    center = np.median(surfels.points, axis=0)
    extent = np.percentile(np.linalg.norm(surfels.points - center, axis=1), 95)
    side = camera_axes(-up, up[[1, 2, 0]])[:2]
    angle = np.radians(turn_deg)
    eye = center + extent * (2.0 * (np.cos(angle) * side[0] + np.sin(angle) * side[1]) + 2.0 * tilt * up)
    axes = camera_axes(center - eye, up)
    width = height = size * SUPERSAMPLING
    focal = 0.9 * width * np.sqrt(1 + tilt * tilt)

    def spots(s, radius_m, color):
        p = (s.points - eye) @ axes.T
        z = np.maximum(p[:, 2], 0.1 * extent)
        return Spots(focal * p[:, 0] / z + width / 2, focal * p[:, 1] / z + height / 2, z, focal / z,
                     focal / z * radius_m, s.normals @ axes.T, color)

    to_camera = (eye - surfels.points) / np.linalg.norm(eye - surfels.points, axis=1)[:, None]
    facing = np.einsum("ij,ij->i", surfels.normals, to_camera) > 0
    seen = surfels.only(facing)
    layers = [spots(seen, seen.radii, shade(seen, to_camera[facing], up))]
    if path is not None:
        layers.append(spots(path, PATH_RADIUS * 2 * extent / focal, path.colors))
    return render(layers, width, height)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("map", help="map.ply of a run")
    parser.add_argument("out", help="start of the names of the pictures")
    parser.add_argument("--trajectory", help="trajectory.txt of the run: draw the camera's way")
    parser.add_argument("--size", type=int, default=1000, help="longer side at most, pixels (default 1000)")
    parser.add_argument("--up", type=float, nargs=3, default=[0, -1, 0], metavar=("X", "Y", "Z"), help="default 0 -1 0")
    parser.add_argument("--cut", type=float, default=0.0, help="leave out the highest so many metres")
    parser.add_argument("--turn-deg", type=float, default=40, help="direction of the raised corner (default 40)")
    parser.add_argument("--tilt", type=float, default=0.9, help="height of the corner over its distance (default 0.9)")
    arguments = parser.parse_args()

    up = np.array(arguments.up, np.float32)
    up /= np.linalg.norm(up)
    surfels = read_map(arguments.map, up, arguments.cut)
    path = path_surfels(arguments.trajectory, 0.005) if arguments.trajectory else None
    for name, image in (("top", top_view(surfels, path, up, arguments.size)),
                        ("view", corner_view(surfels, path, up, arguments.size, arguments.turn_deg, arguments.tilt))):
        file = f"{arguments.out}_{name}.png"
        pixels = np.rint(255 * np.clip(image, 0, 1)).astype(np.uint8)
        Image.fromarray(pixels).quantize(256, kmeans=4).save(file, optimize=True)
        print(file)


if __name__ == "__main__":
    main()
