# SPDX-License-Identifier: MIT
"""Plots as SVG that follows the page's colours: matplotlib draws with marker colours, which become CSS variables."""
import io
import re

import matplotlib

matplotlib.use("svg")
from matplotlib import pyplot as plt  # noqa: E402  (the backend comes first)
import numpy as np  # noqa: E402

# Colours that nothing else uses, and the CSS variables that they stand for.
INK, FAINT, GRID, GOOD, BAD, BEFORE, AFTER, TRUTH = (f"#01020{k}" for k in range(1, 9))
VARIABLES = {INK: "ink", FAINT: "faint", GRID: "grid", GOOD: "good", BAD: "bad", BEFORE: "before", AFTER: "after",
             TRUTH: "truth"}
STAGES = {"odometry": "tracking", "fusion": "fusion", "frame": "one frame, all", "capture_to_pose": "capture to pose",
          "proposal": "proposals", "loop_solve": "pose graph solve", "loop_score": "map score",
          "loop_test": "loop test", "correction": "correction"}

plt.rcParams.update({
    "svg.fonttype": "none", "svg.hashsalt": "loopsift", "font.family": "sans-serif", "font.size": 9,
    "text.color": INK, "axes.labelcolor": INK, "axes.edgecolor": FAINT, "xtick.color": FAINT, "ytick.color": FAINT,
    "xtick.labelcolor": INK, "ytick.labelcolor": INK, "axes.linewidth": 0.8, "axes.spines.top": False,
    "axes.spines.right": False, "axes.grid": True, "grid.color": GRID, "grid.linewidth": 0.6, "axes.axisbelow": True,
    "figure.facecolor": "none", "axes.facecolor": "none", "legend.frameon": False, "legend.fontsize": 8.5,
    "lines.linewidth": 1.5, "lines.solid_capstyle": "round"})


def to_svg(figure, label):
    """The figure as inline SVG, its fonts and colours the page's."""
    stream = io.StringIO()
    figure.savefig(stream, format="svg", bbox_inches="tight", pad_inches=0.04, metadata={"Date": None})
    plt.close(figure)
    svg = stream.getvalue()
    svg = svg[svg.index("<svg"):]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.S)
    for marker, name in VARIABLES.items():
        svg = svg.replace(marker, f"var(--{name})")
    svg = re.sub(r"font: ([0-9.]+)px [^;\"]*", r"font: \1px var(--sans)", svg)
    prefix = re.sub(r"\W", "", label)  # ids must differ between the figures of one page
    svg = re.sub(r'\bid="', f'id="{prefix}-', svg)
    svg = re.sub(r'(href="#|url\(#)', rf"\g<1>{prefix}-", svg)
    svg = re.sub(r'<svg ([^>]*?)width="[^"]*" ([^>]*?)height="[^"]*"|<svg ', r"<svg \1\2", svg, count=1)
    svg = re.sub(r' (?:width|height)="[0-9.]+pt"', "", svg, count=2)
    return svg.replace("<svg ", f'<svg role="img" aria-label="{label}" ', 1)


def axes(height=2.6, width=4.4):
    figure, ax = plt.subplots(figsize=(width, height))
    return figure, ax


def legend_above(ax, columns):
    ax.legend(loc="lower center", bbox_to_anchor=(0.48, 0.99), ncol=columns, handletextpad=0.5, columnspacing=1.4)


def value_labels(ax, values, rows, pattern):
    """Numbers at the ends of horizontal bars."""
    for y, value in zip(rows, values):
        ax.annotate(pattern.format(value), (value, y), (4, 0), textcoords="offset points", va="center")


def error_over_time(truth):
    """truth: {name: {time_s, error_m, ate_rmse_m}} of the odometry and the corrected trajectory."""
    figure, ax = axes()
    for name, color, label in (("odometry", BEFORE, "before"), ("corrected", AFTER, "after")):
        if name in truth:
            t = np.array(truth[name]["time_s"])
            ax.plot(t - t[0], np.array(truth[name]["error_m"]) * 100, color=color,
                    label=f"{label}: RMSE {truth[name]['ate_rmse_m'] * 100:.1f} cm")
    ax.set(xlabel="time, s", ylabel="position error, cm", ylim=(0, None))
    legend_above(ax, 2)
    return to_svg(figure, "Position error over time")


def ranking_curve(ranking):
    """As the paper's figure: precision over recall along the ranking, accepted loops as dots."""
    figure, ax = axes(height=2.9)
    points = ranking["curve"]
    recall, precision = (np.array([p[k] for p in points]) * 100 for k in ("recall", "precision"))
    ax.plot(recall, precision, color=AFTER, drawstyle="default", label="all loops, best rank first", zorder=2)
    for correct, color, label in ((True, GOOD, "accepted"), (False, BAD, "accepted, not true")):
        chosen = [k for k, p in enumerate(points) if p["accepted"] and p["correct"] == correct]
        if chosen:
            ax.plot(recall[chosen], precision[chosen], "o", color=color, markersize=6, markeredgecolor=INK,
                    markeredgewidth=0.7, label=f"{label} ({len(chosen)})", zorder=3)
    ax.set(xlabel="recall, %", ylabel="precision, %", xlim=(0, 103), ylim=(0, 106))
    ax.legend(loc="lower left")
    return to_svg(figure, "Precision and recall of the ranking")


def loop_tests(loops):
    """Why each loop was kept or not: what the map's score became with it, against the best score before."""
    tested = [x for x in loops if x["rank"] >= 0 and x["tested_dmp"] is not None and x["best_dmp_before"]]
    if not tested:
        return None
    figure, ax = axes(height=2.9)
    change = np.array([100 * (x["tested_dmp"] / x["best_dmp_before"] - 1) for x in tested])
    rank = np.array([x["rank"] for x in tested])
    accepted = np.array([x["decision"] == "accepted" for x in tested])
    ax.axhline(0, color=INK, linewidth=0.9)
    ax.plot(rank[~accepted], change[~accepted], "o", color=BAD, markersize=3.2, alpha=0.75,
            label=f"refused ({np.count_nonzero(~accepted)})")
    ax.plot(rank[accepted], change[accepted], "o", color=GOOD, markersize=6, markeredgecolor=INK, markeredgewidth=0.7,
            label=f"accepted ({np.count_nonzero(accepted)})")
    ax.set_yscale("symlog", linthresh=max(0.01, float(np.percentile(np.abs(change), 20))))
    ax.yaxis.set_major_formatter(lambda v, _: f"{v:+g}" if v else "0")
    ax.set(xlabel="rank", ylabel="change of the score, %")
    legend_above(ax, 2)
    return to_svg(figure, "Change of the map score with each loop")


def dmp_views(views):
    """views: {time_s, before, after} per view, m²."""
    figure, ax = axes()
    t = np.array(views["time_s"])
    before, after = np.array(views["before"]) * 1e4, np.array(views["after"]) * 1e4
    t = t - t[0]
    ax.fill_between(t, before, after, where=after < before, color=GOOD, alpha=0.22, linewidth=0, interpolate=True)
    ax.fill_between(t, before, after, where=after > before, color=BAD, alpha=0.22, linewidth=0, interpolate=True)
    ax.plot(t, before, color=BEFORE, label=f"before: mean {before.mean():.1f} cm²")
    ax.plot(t, after, color=AFTER, label=f"after: mean {after.mean():.1f} cm²")
    ax.set(xlabel="time of the view, s", ylabel="DMP of the view, cm²", ylim=(0, None))
    legend_above(ax, 2)
    return to_svg(figure, "Map residual of each view")


def residual_distribution(residual):
    """residual: {"before", "after": m, by surfel, NaN where unknown}: the share of surfels below each value."""
    figure, ax = axes()
    share = np.linspace(0, 100, 201)
    for state, color in (("before", BEFORE), ("after", AFTER)):
        values = 100 * np.nanpercentile(residual[state], share)
        ax.plot(values, share, color=color, label=f"{state}: median {values[100]:.1f} cm")
    ax.set_xscale("log")
    ax.xaxis.set_major_formatter(lambda v, _: f"{v:g}")
    ax.set(xlabel="residual of a surfel, cm", ylabel="surfels below it, %", ylim=(0, 101),
           xlim=(100 * np.nanpercentile(residual["after"], 1), 100 * np.nanpercentile(residual["before"], 99.8)))
    legend_above(ax, 2)
    return to_svg(figure, "Distribution of the residual over the map")


def dmp_totals(before, after):
    figure, ax = axes(height=1.3)
    ax.barh([1, 0], [before, after], color=[BEFORE, AFTER], height=0.6)
    value_labels(ax, (before, after), (1, 0), "{:.2f}")
    ax.set(yticks=[1, 0], yticklabels=["before", "after"], xlabel="dense map posterior, m²",
           xlim=(0, 1.15 * max(before, after)))
    ax.grid(axis="y", visible=False)
    return to_svg(figure, "Dense map posterior before and after")


def latency(stages):
    """stages: run.json's latency_ms. Histograms where it has quantiles, else the span from p50 to the largest."""
    shown = [(name, s) for name, s in stages.items() if name in STAGES and s.get("count")]
    if not shown:
        return None
    figure, ax = axes(height=0.55 + 0.36 * len(shown))
    for y, (name, s) in enumerate(reversed(shown)):
        quantiles = np.maximum(np.array(s.get("quantiles") or []), 1e-3)
        if len(quantiles) > 2:
            draw_histogram(ax, y, quantiles)
        ax.plot([s["p50"], s["max"]], [y, y], color=FAINT, linewidth=1.0, zorder=1)
        ax.plot(s["p50"], y, "o", color=AFTER, markersize=5, zorder=3, label="p50" if y == 0 else None)
        ax.plot(s["p99"], y, "|", color=BEFORE, markersize=11, markeredgewidth=2.4, zorder=3,
                label="p99" if y == 0 else None)
        ax.plot(s["max"], y, "|", color=FAINT, markersize=7, markeredgewidth=1.4, label="max" if y == 0 else None)
    ax.set_xscale("log")
    ax.xaxis.set_major_formatter(lambda v, _: f"{v:g}")
    ax.set(xlabel="ms", yticks=range(len(shown)), yticklabels=[STAGES[name] for name, _ in reversed(shown)],
           ylim=(-0.7, len(shown) - 0.3))
    ax.grid(axis="y", visible=False)
    legend_above(ax, 3)
    return to_svg(figure, "Latency of each stage")


def draw_histogram(ax, y, quantiles):
    """Equal shares of the counts between quantiles, as density over the logarithm of time, about the line y."""
    edges = np.log10(quantiles)
    bins = np.linspace(edges[0], edges[-1] + 1e-9, 41)
    counts = np.diff(np.interp(bins, edges, np.linspace(0, 1, len(edges))))
    height = 0.36 * counts / max(counts.max(), 1e-9)
    ax.fill_between(10 ** bins[:-1], y - height, y + height, step="post", color=AFTER, alpha=0.28, linewidth=0)


def memory(figures):
    """Budget, cap and what was resident, and how full each pool was."""
    values = [(label, figures["memory"].get(key)) for label, key in
              (("budget", "budget_bytes"), ("cap", "cap_bytes"), ("largest resident", "peak_rss_bytes"))]
    values = [(label, v / 2**20) for label, v in values if v]
    pools = [(name, p["high_water"] / p["capacity"]) for name, p in figures.get("pools", {}).items()
             if p.get("capacity") and p.get("high_water")]
    if not values:
        return None
    rows = len(values) + len(pools)
    figure, (top, low) = plt.subplots(2, 1, figsize=(4.4, 1.2 + 0.24 * rows), gridspec_kw={
        "height_ratios": [max(len(values), 1), max(len(pools), 1)], "hspace": 0.75 if rows < 9 else 0.5})
    top.barh(range(len(values))[::-1], [v for _, v in values], color=[FAINT, FAINT, AFTER][:len(values)], height=0.6)
    value_labels(top, [v for _, v in values], range(len(values))[::-1], "{:.0f}")
    top.set(yticks=range(len(values))[::-1], yticklabels=[label for label, _ in values], xlabel="MiB",
            xlim=(0, 1.15 * max(v for _, v in values)))
    low.barh(range(len(pools))[::-1], [100 * share for _, share in pools], color=AFTER, height=0.6)
    low.set(yticks=range(len(pools))[::-1], yticklabels=[name for name, _ in pools],
            xlabel="of the pool in use at most, %", xlim=(0, 100))
    for ax in (top, low):
        ax.grid(axis="y", visible=False)
    low.set_visible(bool(pools))
    return to_svg(figure, "Memory")
