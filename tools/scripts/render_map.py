#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Pictures of a map.ply: OUT_top.png from above (orthographic) and OUT_view.png from a raised corner (perspective).

Surfels are drawn as squares of their radius, nearest wins, colour shaded by the normal against a lamp at the camera.
The floor is taken to be level with the first camera: up is -y of the map unless --up says otherwise.
"""
import argparse
import re
import sys

import matplotlib.image
import numpy as np

PLY_TYPES = {"char": "i1", "uchar": "u1", "short": "<i2", "ushort": "<u2", "int": "<i4", "uint": "<u4", "float": "<f4",
             "double": "<f8", "int8": "i1", "uint8": "u1", "int16": "<i2", "uint16": "<u2", "int32": "<i4",
             "uint32": "<u4", "float32": "<f4", "float64": "<f8"}
BACKGROUND = 1.0
MAX_HALF_WIDTH = 6  # pixels; a surfel close to the camera is not drawn larger


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


def camera_axes(forward, up):
    """Rows right, down, forward."""
    forward = forward / np.linalg.norm(forward)
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(forward, right), forward])


def draw(u, v, depth, half_width, color, width, height):
    """Squares of half_width pixels around (u, v); the nearest wins."""
    image = np.full((height * width, 3), BACKGROUND, np.float32)
    pixels, depths, owners = [], [], []
    half_width = np.clip(np.ceil(half_width - 0.5), 0, MAX_HALF_WIDTH).astype(int)
    for w in range(half_width.max() + 1):
        index = np.flatnonzero(half_width == w)
        for dy in range(-w, w + 1):
            for dx in range(-w, w + 1):
                x, y = u[index] + dx, v[index] + dy
                inside = (x >= 0) & (y >= 0) & (x < width) & (y < height)
                pixels.append((y * width + x)[inside])
                depths.append(depth[index][inside])
                owners.append(index[inside])
    pixels, depths, owners = map(np.concatenate, (pixels, depths, owners))
    order = np.lexsort((depths, pixels))
    pixels, first = np.unique(pixels[order], return_index=True)
    image[pixels] = color[owners[order][first]]
    return image.reshape(height, width, 3)


def shade(color, normal, to_camera):
    """Lambert with a lamp at the camera; surfels that face away are dark."""
    facing = np.einsum("ij,ij->i", normal, to_camera)
    return color * (0.35 + 0.65 * np.clip(facing, 0, 1))[:, None]


def top_view(points, normals, color, radius, up, size):
    axes = camera_axes(-up, up[[1, 2, 0]])
    p = points @ axes.T
    low, high = np.percentile(p, 0.2, axis=0), np.percentile(p, 99.8, axis=0)
    scale = size * 0.96 / max(high[0] - low[0], high[1] - low[1])
    width, height = (int((high[k] - low[k]) * scale / 0.96) + 1 for k in (0, 1))
    u = np.rint((p[:, 0] - (low[0] + high[0]) / 2) * scale + width / 2).astype(int)
    v = np.rint((p[:, 1] - (low[1] + high[1]) / 2) * scale + height / 2).astype(int)
    lit = shade(color, normals, np.broadcast_to(up, points.shape))
    return draw(u, v, p[:, 2], radius * scale, lit, width, height)


def corner_view(points, normals, color, radius, up, size, turn_deg):
    center = np.median(points, axis=0)
    extent = np.percentile(np.linalg.norm(points - center, axis=1), 95)
    side = camera_axes(-up, up[[1, 2, 0]])[:2]
    angle = np.radians(turn_deg)
    eye = center + extent * (2.0 * (np.cos(angle) * side[0] + np.sin(angle) * side[1]) + 1.5 * up)
    axes = camera_axes(center - eye, up)
    width, height = size, size * 3 // 4
    focal = 0.95 * width
    p = (points - eye) @ axes.T
    keep = p[:, 2] > 0.1 * extent
    points, normals, color, radius, p = (a[keep] for a in (points, normals, color, radius, p))
    u = np.rint(focal * p[:, 0] / p[:, 2] + width / 2).astype(int)
    v = np.rint(focal * p[:, 1] / p[:, 2] + height / 2).astype(int)
    to_camera = (eye - points) / np.linalg.norm(eye - points, axis=1)[:, None]
    facing = np.einsum("ij,ij->i", normals, to_camera) > 0  # a look into the room through the backs of its walls
    lit = shade(color, normals, to_camera)
    return draw(u[facing], v[facing], p[facing, 2], (focal * radius / p[:, 2])[facing], lit[facing], width, height)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("map", help="map.ply of a run")
    parser.add_argument("out", help="start of the names of the pictures")
    parser.add_argument("--size", type=int, default=1000, help="longer side, pixels (default 1000)")
    parser.add_argument("--up", type=float, nargs=3, default=[0, -1, 0], metavar=("X", "Y", "Z"), help="default 0 -1 0")
    parser.add_argument("--cut", type=float, default=0.0, help="leave out the highest so many metres (a ceiling)")
    parser.add_argument("--turn-deg", type=float, default=40, help="direction of the raised corner (default 40)")
    arguments = parser.parse_args()

    vertices = read_ply(arguments.map)
    up = np.array(arguments.up, np.float32)
    up /= np.linalg.norm(up)
    points = columns(vertices, ["x", "y", "z"], 0)
    height = points @ up
    keep = height <= np.percentile(height, 99.8) - arguments.cut if arguments.cut > 0 else np.ones(len(points), bool)
    vertices, points = vertices[keep], points[keep]
    surfels = (points, columns(vertices, ["nx", "ny", "nz"], 0), columns(vertices, ["red", "green", "blue"], 180) / 255,
               columns(vertices, ["radius"], 0.01)[:, 0])
    for name, image in (("top", top_view(*surfels, up, arguments.size)),
                        ("view", corner_view(*surfels, up, arguments.size, arguments.turn_deg))):
        path = f"{arguments.out}_{name}.png"
        matplotlib.image.imsave(path, np.clip(image, 0, 1))
        print(path)


if __name__ == "__main__":
    main()
