# SPDX-License-Identifier: MIT
"""The report as one HTML page: no network, no script; light or dark as the reader's system has it."""
import os
from html import escape

from map_pictures import FULL_RESIDUAL_M, HEIGHT_STOPS, RESIDUAL_STOPS, css_gradient

NAMES = {"seen": "as seen", "height": "height", "residual": "residual"}


def figure(content, caption):
    return f"<figure>{content}<figcaption>{caption}</figcaption></figure>" if content else ""


def section(title, *parts):
    body = "".join(part for part in parts if part)
    return f"<section><h2>{title}</h2>{body}</section>" if body else ""


def pair(*figures):
    return f'<div class="pair">{"".join(figures)}</div>' if any(figures) else ""


def tile(value, label):
    return f"<li><b>{value}</b><span>{label}</span></li>"


def centimetres(before, after):
    return f"{100 * before:.1f} → {100 * after:.1f} cm"


def tiles(run, evaluation):
    """The figures that a reader looks for first."""
    truth, figures, items = evaluation.get("truth", {}), run.figures or {}, []
    if "odometry" in truth and "corrected" in truth:
        items.append(tile(centimetres(truth["odometry"]["ate_rmse_m"], truth["corrected"]["ate_rmse_m"]),
                          "trajectory error, odometry → corrected"))
    dmp = figures.get("dmp", {})
    if dmp.get("odometry") is not None and dmp.get("final") is not None:
        items.append(tile(f"{dmp['odometry']:.2f} → {dmp['final']:.2f} m²", "dense map posterior, before → after"))
    if run.loops is not None:
        accepted = [x for x in run.loops if x["decision"] == "accepted"]
        wrong = sum(x.get("correct") is False for x in accepted)
        judged = f", {wrong} of them wrong" if any(x.get("correct") is not None for x in accepted) else ""
        items.append(tile(f"{len(accepted)} of {len(run.loops)}", f"loops accepted{judged}"))
    frames = figures.get("frames")
    if frames:
        lost = f", {frames['lost']} lost" if frames.get("lost") else ""
        items.append(tile(f"{frames['tracked']} of {frames['received']}", f"frames tracked{lost}"))
    frame = figures.get("latency_ms", {}).get("frame")
    if frame and frame.get("count"):
        items.append(tile(f"{frame['p50']:.1f} / {frame['p99']:.1f} ms", "a frame: median / 99th percentile"))
    if figures.get("memory", {}).get("peak_rss_bytes"):
        items.append(tile(f"{figures['memory']['peak_rss_bytes'] / 2**20:.0f} MiB", "memory at most"))
    return f'<ul class="tiles">{"".join(items)}</ul>' if items else ""


def map_view(view):
    cells = []
    for state in view["states"]:
        images = "".join(f'<img class="{name}" src="{address}" width="{view["width"]}" height="{view["height"]}" '
                         f'alt="{view["title"]}, {state["name"]}, {NAMES[name]}">'
                         for name, address in state["pictures"].items())
        way = (f'<svg viewBox="0 0 {view["width"]} {view["height"]}">'
               f'<polyline class="way" points="{state["path"]}"/></svg>' if state["path"] else "")
        cells.append(f'<div><p class="state">{state["name"]} correction</p>'
                     f'<div class="picture">{images}{way}</div></div>')
    single = " single" if len(cells) == 1 else ""
    return f'<h3>{view["title"]}</h3><div class="maps{single}">{"".join(cells)}</div>'


def map_section(pictures):
    if pictures is None:
        return ""
    colourings = list(pictures["views"][0]["states"][0]["pictures"])
    first = "residual" if "residual" in colourings else "seen"
    choice = "".join(f'<input class="choice" type="radio" name="colouring" id="as-{c}"'
                     f'{" checked" if c == first else ""}><label for="as-{c}">{NAMES[c]}</label>' for c in colourings)
    low, high = pictures["height_range"]
    legends = ('<div class="legend seen">the colours that the camera saw</div>'
               f'<div class="legend height">low<i style="background:{css_gradient(HEIGHT_STOPS)}"></i>'
               f"high: {high - low:.1f} m</div>"
               '<div class="legend residual">the map predicts what was measured'
               f'<i style="background:{css_gradient(RESIDUAL_STOPS)}"></i>'
               f'{100 * FULL_RESIDUAL_M:.0f} cm off or more &ensp; <i class="unseen"></i>in none of the views</div>')
    about = ("The residual of a surfel is |predicted − measured depth| at its pixel, the mean over the views that see "
             "it. " if "residual" in colourings else "With --source the report colours the map by its residual. ")
    return section("The map", choice, legends, '<div class="views">', *map(map_view, pictures["views"]), "</div>",
                   f"<p class='sub'>{pictures['surfels']:,} surfels{residual_words(pictures['residual'])}. {about}"
                   "Both maps hold the same fragments; only their poses differ. Ceilings are left out from above.</p>")


def residual_words(residual):
    known = {name: r for name, r in residual.items() if r}
    if not known:
        return ""
    return "; residual (median, 95 %) " + ", ".join(
        f"{100 * r['median_m']:.1f} and {100 * r['p95_m']:.1f} cm {name}" for name, r in known.items())


def cell(value, pattern, factor=1.0):
    return "–" if value is None else pattern.format(value * factor)


def loop_row(loop, judged):
    kind = "accepted" if loop["decision"] == "accepted" else "refused"
    verdict = ""
    if judged:
        name = {True: "true", False: "false"}.get(loop.get("correct"), "–")
        verdict = (f"<td>{name}</td><td>{cell(loop.get('error_m'), '{:.1f}', 100)}</td>"
                   f"<td>{cell(loop.get('error_deg'), '{:.1f}')}</td>")
    rank = loop["rank"] if loop["rank"] >= 0 else "–"
    return (f'<tr class="{kind}"><td>{loop["id"]}</td><td>{loop["i"]} – {loop["j"]}</td><td>{rank}</td>'
            f"<td>{cell(loop['single_dmp'], '{:.5g}')}</td><td>{cell(loop['tested_dmp'], '{:.6g}')}</td>"
            f"<td>{cell(loop['best_dmp_before'], '{:.6g}')}</td>{verdict}"
            f'<td class="text">{escape(loop["decision"])}: {escape(loop["reason"])}</td></tr>')


def loop_table(loops, judged):
    verdict = "<th>truth</th><th>off, cm</th><th>off, °</th>" if judged else ""
    rows = "".join(loop_row(loop, judged) for loop in sorted(loops, key=lambda x: (x["rank"] < 0, x["rank"])))
    return ('<div class="scroll"><table><thead><tr><th>loop</th><th>fragments</th><th>rank</th><th>score alone</th>'
            f'<th>when tested</th><th>best before</th>{verdict}<th class="text">decision</th></tr></thead>'
            f"<tbody>{rows}</tbody></table></div>")


def loop_tables(loops):
    if not loops:
        return "<p>No loop was proposed.</p>" if loops is not None else ""
    judged = any(x.get("correct") is not None or x.get("error_m") is not None for x in loops)
    accepted = [x for x in loops if x["decision"] == "accepted"]
    refused = [x for x in loops if x["decision"] != "accepted"]
    parts = [loop_table(accepted, judged) if accepted else "<p>No loop was accepted.</p>"]
    if refused:
        parts.append(f"<details><summary>The {len(refused)} loops that were not accepted</summary>"
                     f"{loop_table(refused, judged)}</details>")
    return "".join(parts)


def key(*entries):
    return "".join(f'<span class="key {css}" style="color:var(--{color})"></span>{name}'
                   for css, color, name in entries)


def html(run, title, sections, evaluation):
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "page.css"), encoding="utf-8") as file:
        style = file.read()
    figures = run.figures or {}
    about = [escape(str(figures["source"]))] if figures.get("source") else []
    if figures.get("sequence_duration_s") and figures.get("wall_s"):
        about.append(f"{figures['sequence_duration_s']:.1f} s recorded, run in {figures['wall_s']:.1f} s")
    notes = "".join(f"<p>{escape(note)}</p>" for note in run.notes + evaluation.get("notes", []))
    notes = f'<div class="notes" role="note">{notes}</div>' if notes else ""
    return ('<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
            '<meta name="viewport" content="width=device-width, initial-scale=1">'
            f"<title>{escape(title)} – loopsift</title><style>{style}</style></head><body>"
            f'<header><h1>{escape(title)}</h1><p class="sub">{" · ".join(about)}</p></header>{notes}'
            f'{tiles(run, evaluation)}{"".join(sections)}'
            f"<footer>Made by loopsift-tool report from {escape(os.path.abspath(run.folder))}.</footer>"
            "</body></html>\n")
