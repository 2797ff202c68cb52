#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Draws the output folder of a run as one HTML page. `loopsift-tool report` calls it with what it evaluated.

usage: report.py DIR OUT.html EVALUATION_FOLDER TITLE      exit codes: 0 done, 2 nothing to show, 3 a library is missing
"""
import json
import os
import sys

try:
    import matplotlib  # noqa: F401
    import numpy as np
    from PIL import features
except ImportError as missing:
    print(f"report: needs {missing.name}; install what it draws with: apt-get install python3-numpy python3-matplotlib "
          "python3-pil", file=sys.stderr)
    sys.exit(3)

import loop_arcs
import map_pictures
import page
import plots
from run_files import Run


def step(text):
    print(f"report: {text}", file=sys.stderr, flush=True)


def judge(run, evaluation):
    """What the evaluation knows about each loop, beside its row of loops.csv."""
    verdicts = {v["id"]: v for v in evaluation.get("loops", [])}
    for loop in run.loops or []:
        loop.update({k: v for k, v in verdicts.get(loop["id"], {}).items() if k != "id"})


def trajectory_section(evaluation, up, axes):
    truth = evaluation.get("truth")
    if not truth:
        return ""
    keys = page.key(("truth", "truth", "ground truth"), ("", "before", "odometry"), ("", "after", "corrected"))
    rows = "".join(f'<tr><td class="text">{label}</td>' + "".join(
        f"<td>{'–' if t.get(k) is None else format(t[k] * f, '.2f')}</td>" for k, f in
        (("ate_rmse_m", 100), ("ate_mean_m", 100), ("ate_max_m", 100), ("rpe_trans_rmse_m", 100),
         ("rpe_rot_rmse_deg", 1))) + f"<td>{t['pairs']}</td></tr>"
        for label, t in (("odometry", truth.get("odometry")), ("corrected", truth.get("corrected"))) if t)
    table = ('<div class="scroll"><table><thead><tr><th class="text"></th><th>ATE RMSE, cm</th><th>mean, cm</th>'
             "<th>max, cm</th><th>RPE in 1 s, cm</th><th>RPE, °</th><th>poses</th></tr></thead>"
             f"<tbody>{rows}</tbody></table></div>")
    return page.section("Trajectory against ground truth", table, page.pair(
        page.figure(loop_arcs.trajectories(truth, up, axes), keys + ". From above, aligned rigidly."),
        page.figure(plots.error_over_time(truth), "Distance from the true position after rigid alignment.")))


def loop_section(run, evaluation, up, axes):
    if not run.loops:
        return page.section("Loops", page.loop_tables(run.loops))
    ranking = evaluation.get("ranking")
    curve = page.figure(plots.ranking_curve(ranking), "Precision and recall along the ranking, best first; dots: the "
                        f"loops that were accepted in the end. {ranking['about']}") if ranking else ""
    tests = page.figure(plots.loop_tests(run.loops), "Change of the score when each loop was last tested on top of "
                        "those accepted before it; below zero the map explains the images better. A loop that improves "
                        "the score is still refused when the improvement is within its standard error or a motion next "
                        "to it explains the fragments better.")
    arcs = page.figure(loop_arcs.loop_arcs(run, up, axes), page.key(("", "good", "accepted"), ("", "bad", "refused")) +
                       ". Arcs join the middles of the two fragments; point at one for its numbers.")
    return page.section("Loops", arcs, page.pair(curve, tests), page.loop_tables(run.loops))


def residual_section(run, evaluation):
    views = evaluation.get("dmp_views")
    if views:
        spread = plots.residual_distribution(run.residual) if len(run.residual) == 2 else ""
        return page.section("Dense map posterior", page.pair(
            page.figure(plots.dmp_views(views), "Mean squared difference between the depth that the run's map predicts "
                        f"and the measured one, in {len(views['time_s'])} frames of the recording, before and after "
                        "correction; green where it fell."),
            page.figure(spread, "How large the residual of a surfel is, over the whole map.")))
    dmp = (run.figures or {}).get("dmp", {})
    if dmp.get("odometry") is None or dmp.get("final") is None:
        return ""
    return page.section("Dense map posterior", page.figure(
        plots.dmp_totals(dmp["odometry"], dmp["final"]),
        f"Sum over {dmp['views']} views. With --source the report shows each view."))


def machine_section(run):
    figures = run.figures or {}
    latency = plots.latency(figures["latency_ms"]) if figures.get("latency_ms") else ""
    memory = plots.memory(figures) if figures.get("memory") else ""
    return page.section("Latency and memory", page.pair(
        page.figure(latency, "Time of each stage: the median, the 99th percentile and the longest; behind them the "
                    "distribution, where the run kept it."),
        page.figure(memory, "Memory against the budget that was computed before the first frame, and how full each "
                    "fixed store became.")))


def main():
    folder, out, evaluation_folder, title = sys.argv[1:5]
    if not features.check("webp"):
        print("report: python3-pil was built without WebP; install Debian's python3-pil", file=sys.stderr)
        return 3
    with open(os.path.join(evaluation_folder, "evaluation.json"), encoding="utf-8") as file:
        evaluation = json.load(file)
    step("reading the run")
    run = Run(folder)
    if run.is_empty:
        print(f"report: {folder} holds nothing of a run that could be shown; give the folder that --out named.\n  "
              + "\n  ".join(run.notes), file=sys.stderr)
        return 2
    run.take_residual(evaluation_folder)
    judge(run, evaluation)
    step("drawing the map")
    pictures = map_pictures.map_pictures(run)
    up, axes = (pictures["up"], pictures["axes"]) if pictures else (np.array([0.0, -1.0, 0.0]), None)
    step("drawing the plots")
    sections = [page.map_section(pictures), trajectory_section(evaluation, up, axes),
                loop_section(run, evaluation, up, axes), residual_section(run, evaluation), machine_section(run)]
    try:
        with open(out, "w", encoding="utf-8") as file:
            file.write(page.html(run, title, sections, evaluation))
    except OSError as error:
        print(f"report: {out} cannot be written: {error.strerror}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
