#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs a command, records its resident memory twice a second, and draws it against the time.

  soak.py --out soak -- loopsift --source 'synth:room?laps=16&frames=18000' --rate max --out out/soak

writes soak.csv (seconds, resident KiB, anonymous KiB, largest so far KiB) and soak.png. Needs python3-matplotlib.
Exit code: the command's; 1 when memory moved by more than 1 MiB after the tenth second.
"""
import argparse
import csv
import subprocess
import sys
import time

SETTLED_S = 10
ALLOWED_KIB = 1024


def memory_kib(pid):
    """(resident, anonymous, largest so far), or None once the process is gone."""
    try:
        with open(f"/proc/{pid}/status", encoding="ascii") as status:
            fields = dict(line.split(":", 1) for line in status)
        return tuple(int(fields[name].split()[0]) for name in ("VmRSS", "RssAnon", "VmHWM"))
    except (OSError, KeyError):
        return None


def record(command, path):
    """Runs the command; the rows that were written, and its exit code."""
    rows = []
    started = time.monotonic()
    with subprocess.Popen(command) as process, open(path, "w", newline="", encoding="ascii") as file:
        writer = csv.writer(file)
        while process.poll() is None:
            memory = memory_kib(process.pid)
            if memory:
                rows.append((time.monotonic() - started, *memory))
                writer.writerow([f"{rows[-1][0]:.1f}", *memory])
                file.flush()
            time.sleep(0.5)
        return rows, process.returncode


def draw(rows, cap_mib, path):
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot
    figure, axes = pyplot.subplots(figsize=(8, 3))
    axes.plot([row[0] for row in rows], [row[1] / 1024 for row in rows], label="resident")
    if cap_mib:
        axes.axhline(cap_mib, color="tab:red", linewidth=1, label="memory.cap_mib")
    axes.set(xlabel="s", ylabel="MiB", ylim=(0, None))
    axes.legend(loc="lower right")
    figure.tight_layout()
    figure.savefig(path, dpi=90)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", required=True, help="name of the files, without .csv and .png")
    parser.add_argument("--cap-mib", type=float, default=0, help="a line at the profile's cap")
    parser.add_argument("command", nargs=argparse.REMAINDER)
    arguments = parser.parse_args()
    command = arguments.command[1:] if arguments.command[:1] == ["--"] else arguments.command
    rows, exit_code = record(command, arguments.out + ".csv")
    if not rows:
        return exit_code or 1
    draw(rows, arguments.cap_mib, arguments.out + ".png")
    settled = [row[1] for row in rows if row[0] >= SETTLED_S] or [rows[-1][1]]
    print(f"peak {rows[-1][3] / 1024:.1f} MiB; after {SETTLED_S} s from {min(settled) / 1024:.1f} "
          f"to {max(settled) / 1024:.1f} MiB")
    return exit_code or int(max(settled) - min(settled) > ALLOWED_KIB)


if __name__ == "__main__":
    sys.exit(main())
