# SPDX-License-Identifier: MIT
"""What a run left in its folder. A file that is not there or cannot be read becomes a note, not a failure: a report on
a half-finished run shows what there is."""
import csv
import json
import os

import numpy as np

from surfel_renderer import MapError, read_map


def number(text):
    try:
        return float(text)
    except (TypeError, ValueError):
        return None


def read_trajectory(path):
    """Rows t x y z qx qy qz qw."""
    rows = np.loadtxt(path, ndmin=2)
    if rows.size == 0 or rows.shape[1] != 8:
        raise ValueError("holds no TUM poses (t tx ty tz qx qy qz qw)")
    return rows


def read_json(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def read_loops(path):
    """Rows of loops.csv, numbers as numbers, what is empty as None."""
    with open(path, newline="", encoding="utf-8") as file:
        loops = []
        for row in csv.DictReader(file):
            values = [number(row.get(key)) for key in ("id", "fragment_i", "fragment_j", "rank")]
            if None in values:
                raise ValueError(f"row {len(loops) + 1} is cut off or has no id, fragments and rank")
            loop = dict(zip(("id", "i", "j", "rank"), map(int, values)))
            for key in ("single_dmp", "tested_dmp", "best_dmp_before"):
                loop[key] = number(row.get(key))
            loop["decision"], loop["reason"] = row.get("decision") or "", row.get("reason") or ""
            loops.append(loop)
        return loops


class Run:
    """The files of a run; None for what is not there, with a sentence in `notes`."""

    def __init__(self, folder):
        self.folder, self.notes = folder, []
        self.odometry = self._read("trajectory_odometry.txt", read_trajectory)
        self.corrected = self._read("trajectory.txt", read_trajectory)
        self.map = self._read("map.ply", read_map)
        self.loops = self._read("loops.csv", read_loops)
        self.figures = self._read("run.json", read_json)
        self.residual = {}  # "before", "after": of each surfel of the map, m; NaN where no view saw it

    def take_residual(self, folder):
        """What the evaluation measured, where it did."""
        for state in ("before", "after"):
            path = os.path.join(folder, f"residual_{state}.f32")
            if self.map is not None and os.path.exists(path):
                values = np.fromfile(path, np.float32)
                if len(values) == len(self.map.points):
                    self.residual[state] = values

    def _read(self, name, reader):
        path = os.path.join(self.folder, name)
        if not os.path.exists(path):
            self.notes.append(f"{name} is not there: the run did not get that far.")
            return None
        try:
            return reader(path)
        except MapError as error:
            self.notes.append(str(error).replace(self.folder + "/", "") + ".")
        except (OSError, ValueError) as error:
            self.notes.append(f"{name} cannot be used: {error}.")
        return None

    @property
    def is_empty(self):
        return all(x is None for x in (self.odometry, self.corrected, self.map, self.loops, self.figures))
