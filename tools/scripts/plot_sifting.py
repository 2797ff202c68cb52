#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Figures about the sifter. Which ones is for the arguments to say:
  --cost JSON … --png FILE     cost of a loop against the size of the map, from `bench_sifter --benchmark_out=JSON`
  --online JSON --png FILE     score and error as a map grows, online and batch, from the same
  --rankings FOLDER …          Kendall's tau-b between the ranking of loops in the first folder and in the others, and
                               the loops that both accept; folders are those of `loopsift --out`. Loops are the same
                               when they join the same fragments by motions within 5 mm and 0.005 of each other"""
import argparse
import collections
import csv
import json
import sys


def read_loops(folder):
    """[(i, j, motion as twelve numbers, row of loops.csv)]"""
    with open(f"{folder}/proposals.log", encoding="ascii") as file:
        numbers = [float(word) for word in file.read().split()]
    with open(f"{folder}/loops.csv", encoding="ascii", newline="") as file:
        rows = sorted(csv.DictReader(file), key=lambda row: int(row["id"]))
    return [(row["fragment_i"], row["fragment_j"], numbers[19 * k + 3:19 * k + 15], row) for k, row in enumerate(rows)]


def pair_up(first, second):
    """[(row, row)] of the loops that are in both and ranked in both."""
    pairs = []
    for i, j, motion, row in first:
        for other_i, other_j, other_motion, other in second:
            same = (i, j) == (other_i, other_j) and max(abs(a - b) for a, b in zip(motion, other_motion)) < 0.005
            if same and row["rank"] != "-1" and other["rank"] != "-1":
                pairs.append((row, other))
                break
    return pairs


def sign(x):
    return (x > 0) - (x < 0)


def kendall_tau_b(a, b):
    """Kendall, "The treatment of ties in ranking problems" (1945); every pair is looked at."""
    agree = ties_a = ties_b = pairs = 0
    for k in range(len(a)):
        for m in range(k):
            x, y = sign(a[k] - a[m]), sign(b[k] - b[m])
            agree, ties_a, ties_b, pairs = agree + x * y, ties_a + (x == 0), ties_b + (y == 0), pairs + 1
    return agree / ((pairs - ties_a) * (pairs - ties_b)) ** 0.5


def compare_rankings(folders):
    first = read_loops(folders[0])
    print("| run | loops in both | tau | tau of its better half | it accepts | both accept |\n|---|---|---|---|---|---|")
    for folder in folders:
        second = read_loops(folder)
        pairs = sorted(pair_up(first, second), key=lambda pair: int(pair[1]["rank"]))

        def tau(of):
            return kendall_tau_b([int(a["rank"]) for a, _ in of], [int(b["rank"]) for _, b in of])

        accepts = sum(loop[3]["decision"] == "accepted" for loop in second)
        both = sum(a["decision"] == b["decision"] == "accepted" for a, b in pairs)
        print(f"| {folder} | {len(pairs)} | {tau(pairs):.3f} | {tau(pairs[:len(pairs) // 2]):.3f} | {accepts} | {both} |")


def new_figure(columns):
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot
    return pyplot.subplots(1, columns, figsize=(4.2 * columns, 3.2), constrained_layout=True)


def read_bench(paths):
    rows = []
    for path in paths:
        with open(path, encoding="utf-8") as file:
            rows += json.load(file)["benchmarks"]
    return rows


def plot_cost(paths, png):
    curves = collections.defaultdict(list)
    for row in read_bench(paths):
        if row.get("loops") == 200:
            curves[row["name"].split("/")[0]].append((row["fragments"], row["test_p50_ms"], row["ms_per_loop"]))
    figure, axes = new_figure(2)
    for name, points in curves.items():
        points.sort()
        fragments = [point[0] for point in points]
        for axis, column in ((axes[0], 1), (axes[1], 2)):
            axis.plot(fragments, [point[column] for point in points], marker="o", label=name)
            per_fragment = points[0][column] / points[0][0]
            axis.plot(fragments, [per_fragment * n for n in fragments], ":", color=axis.lines[-1].get_color(),
                      label=f"{name}, were it linear")
    axes[0].set_ylabel("one test, solve and score, median, ms")
    axes[1].set_ylabel("a loop with all that it causes, mean, ms")
    for axis in axes:
        axis.set_xlabel("fragments")
        axis.set_ylim(bottom=0)
        axis.legend(fontsize=8)
    figure.savefig(png, dpi=110)


def plot_online(path, png):
    rows = [row for row in read_bench([path]) if row["name"].startswith("online/")]
    figure, axes = new_figure(2)
    for axis, quantity in zip(axes, ("dmp", "rmse_m")):
        for kind, style in (("odometry", ":"), ("online", "-"), ("batch", "x")):
            axis.plot([row["fragments"] for row in rows], [row[f"{kind}_{quantity}"] for row in rows], style, label=kind)
        axis.set_xlabel("fragments so far")
        axis.set_ylim(bottom=0)
        axis.legend(fontsize=8)
    axes[0].set_ylabel("DMP, m²")
    axes[1].set_ylabel("error of the fragments' positions, m")
    figure.savefig(png, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cost", nargs="+", metavar="JSON")
    parser.add_argument("--online", metavar="JSON")
    parser.add_argument("--rankings", nargs="+", metavar="FOLDER")
    parser.add_argument("--png")
    arguments = parser.parse_args()
    if (arguments.cost or arguments.online) and not arguments.png:
        parser.error("--png: say which file the picture goes to")
    if arguments.rankings:
        compare_rankings(arguments.rankings)
    if arguments.cost:
        plot_cost(arguments.cost, arguments.png)
    elif arguments.online:
        plot_online(arguments.online, arguments.png)
    return 0


if __name__ == "__main__":
    sys.exit(main())
