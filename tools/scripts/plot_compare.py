#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Draws how loop filters hold up: the CSV that `loopsift-tool compare --sweep` writes, as one picture. Columns are
the sweep's three axes; rows the trajectory's error and the share of wrong loops among those kept. A point is the mean
over the seeds, the band reaches from the best to the worst of them. With --markdown it prints a table instead: of the
JSON of `loopsift-tool compare --json` all figures, of a sweep's CSV the mean errors at the ends of the axes (* where
wrong loops were kept) and at how many points loopsift is the lowest or within 3 mm or 5 % of it."""
import argparse
import collections
import csv
import json

AXES = [("false_loops", "false loops added, per true loop"),
        ("loop_information", "loops' information ×"),
        ("odometry_information", "odometry's information ×")]
OURS = ["loopsift", "loopsift_plain"]
NOT_DRAWN = {"all"}  # plain least squares leaves every scale


def read_rows(path):
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def number(text):
    return float(text) if text else None


def wrong_share(row):
    """Wrong loops among those kept; none kept, none wrong."""
    precision = number(row["precision"])
    return 0.0 if precision is None else 1.0 - precision


def ate_cm(row):
    value = number(row["ate_rmse_m"])
    return None if value is None else 100.0 * value


def curve(rows, axis, name, measure):
    """[(value, mean, lowest, highest)] over the seeds."""
    points = collections.defaultdict(list)
    for row in rows:
        if row["axis"] == axis and row["filter"] == name and measure(row) is not None:
            points[float(row["value"])].append(measure(row))
    return [(value, sum(p) / len(p), min(p), max(p)) for value, p in sorted(points.items())]


def style(name, place):
    if name == "loopsift":
        return {"color": "#c0392b", "linewidth": 2.6, "zorder": 5, "marker": "o", "markersize": 4}
    if name == "loopsift_plain":
        return {"color": "#c0392b", "linewidth": 1.4, "zorder": 4, "linestyle": "--"}
    if name == "none":
        return {"color": "black", "linewidth": 1.2, "linestyle": ":"}
    if name == "all true loops":
        return {"color": "black", "linewidth": 1.2, "linestyle": "-."}
    colors = ["#1f77b4", "#2ca02c", "#ff7f0e", "#9467bd", "#8c564b", "#e377c2", "#7f7f7f", "#bcbd22", "#17becf",
              "#3a5f0b", "#004c6d"]
    return {"color": colors[place % len(colors)], "linewidth": 1.2, "alpha": 0.9}


def draw_axis(plot, rows, names, axis, measure, logarithmic):
    for place, name in enumerate(names):
        points = curve(rows, axis, name, measure)
        if not points:
            continue
        x, mean, low, high = zip(*points)
        plot.plot(x, mean, label=name, **style(name, place))
        if name == "loopsift":
            plot.fill_between(x, low, high, color="#c0392b", alpha=0.15, linewidth=0)
    if axis != "false_loops":
        plot.set_xscale("log")
    if logarithmic:
        plot.set_yscale("log")
    plot.grid(True, which="both", linewidth=0.3, alpha=0.5)


def draw(rows, title, path):
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot
    names = [name for name in dict.fromkeys(row["filter"] for row in rows) if name not in NOT_DRAWN]
    figure, plots = pyplot.subplots(2, 3, figsize=(12, 6.6), sharex="col", sharey="row")
    for column, (axis, label) in enumerate(AXES):
        draw_axis(plots[0][column], rows, names, axis, ate_cm, True)
        draw_axis(plots[1][column], [r for r in rows if r["filter"] != "all true loops"], names, axis, wrong_share,
                  False)
        plots[1][column].set_xlabel(label)
    plots[0][0].set_ylabel("absolute trajectory error, cm")
    plots[1][0].set_ylabel("wrong among the kept")
    handles, labels = plots[0][0].get_legend_handles_labels()
    order = sorted(range(len(labels)), key=lambda k: labels[k] not in OURS)
    figure.legend([handles[k] for k in order], [labels[k] for k in order], loc="lower center", ncol=5, fontsize=8,
                  frameon=False)
    figure.suptitle(title)
    figure.tight_layout(rect=(0, 0.1, 1, 1))
    figure.savefig(path, dpi=85)


def within_goal(rows):
    """At how many points, of how many, loopsift is no worse than 3 mm or 5 % above the lowest published filter."""
    points = collections.defaultdict(dict)
    for row in rows:
        points[row["axis"], row["value"], row["seed"]][row["filter"]] = ate_cm(row)
    good = 0
    for errors in points.values():
        best = min(e for name, e in errors.items() if name not in OURS and name != "all true loops")
        good += errors["loopsift"] <= best + max(0.3, 0.05 * best)
    return good, len(points)


def print_sweep(path):
    rows = read_rows(path)
    ends = []
    for axis, label in (("false_loops", "false {:g}"), ("loop_information", "loops ×{:g}"),
                        ("odometry_information", "odometry ×{:g}")):
        values = sorted({float(row["value"]) for row in rows if row["axis"] == axis})
        ends += [(axis, value, label.format(value)) for value in dict.fromkeys((values[0], values[-1]))]
    print("| error, cm |", " | ".join(label for _, _, label in ends), "|")
    print("|---" * (len(ends) + 1) + "|")
    for name in dict.fromkeys(row["filter"] for row in rows):
        cells = []
        for axis, value, _ in ends:
            here = [r for r in rows if (r["axis"], float(r["value"]), r["filter"]) == (axis, value, name)]
            wrong = "\\*" if any(wrong_share(r) > 0 for r in here) else ""
            cells.append(f"{sum(map(ate_cm, here)) / len(here):.2f}{wrong}")
        print("|", f"**{name}**" if name in OURS else name, "|", " | ".join(cells), "|")
    print("\nloopsift lowest, or within 3 mm or 5 % of the lowest: {} of {} points.".format(*within_goal(rows)))


def print_markdown(path):
    with open(path, encoding="utf-8") as file:
        rows = json.load(file)
    columns = [("accepted", "kept", "{:d}"), ("precision", "precision", "{:.2f}"), ("recall", "recall", "{:.2f}"),
               ("ate_rmse_m", "error, cm", None), ("surface_mean_m", "surface, mm", None), ("dmp", "DMP, m²", "{:.2f}"),
               ("wall_s", "s", "{:.2f}")]
    columns = [column for column in columns if column[0] in rows[0]]
    print("| filter |", " | ".join(column[1] for column in columns), "|")
    print("|---" * (len(columns) + 1) + "|")
    for row in rows:
        cells = []
        for key, _, form in columns:
            value = row[key]
            if value is None:
                cells.append("–")
            elif key == "ate_rmse_m":
                cells.append(f"{100 * value:.2f}")
            elif key == "surface_mean_m":
                cells.append(f"{1000 * value:.1f}")
            else:
                cells.append(form.format(value))
        name = f"**{row['filter']}**" if row["filter"] in OURS else row["filter"]
        print("|", name, "|", " | ".join(cells), "|")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("input", help="the sweep's CSV, or with --markdown also the table's JSON")
    parser.add_argument("picture", nargs="?", help="PNG to write")
    parser.add_argument("--title", default="Loop filters on the same loops")
    parser.add_argument("--markdown", action="store_true", help="print a table")
    arguments = parser.parse_args()
    if arguments.markdown:
        (print_sweep if arguments.input.endswith(".csv") else print_markdown)(arguments.input)
    elif arguments.picture is None:
        parser.error("say where to draw to: SWEEP.csv PICTURE.png")
    else:
        draw(read_rows(arguments.input), arguments.title, arguments.picture)


if __name__ == "__main__":
    main()
