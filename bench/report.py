#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Makes the table from a result of bench/run.

  bench/report.py RESULT.json             prints it
  bench/report.py --readme RESULT.json    writes it into README.md, between the lines <!-- bench: begin --> and <!-- bench: end -->
"""
import json
import math
import os
import re
import statistics
import sys

HEADINGS = {"vtk-cpu": "VTK fixed-point CPU", "vtk-gpu": "VTK GPU mapper", "vtk-iso": "VTK flying edges", "volpack": "VolPack, 1 thread"}


def dump(result):
    """JSON with one line a list of numbers, so that a result can be read and a change to it seen."""
    text = json.dumps(result, indent=1)
    return re.sub(r"\[[^][{}\"]*\]", lambda m: re.sub(r"\s+", " ", m.group(0)).replace("[ ", "[").replace(" ]", "]"), text) + "\n"


def times(run, key):
    """The list of milliseconds of one process."""
    value = run.get(key)
    return [x for x in value if x is not None] if isinstance(value, list) else []


def median(record, program, key):
    every = [x for run in record["runs"].get(program, []) for x in times(run, key)]
    return statistics.median(every) if every else None


def ratios(record, program, key):
    """program's time over ours: of the medians, and the least and greatest of single rounds."""
    ours, theirs = median(record, "pellucid", key), median(record, program, key)
    if not ours or not theirs:
        return None
    rounds = [statistics.median(times(b, key)) / statistics.median(times(a, key))
              for a, b in zip(record["runs"]["pellucid"], record["runs"][program]) if times(a, key) and times(b, key)]
    return theirs / ours, min(rounds, default=theirs / ours), max(rounds, default=theirs / ours)


def number(ms):
    return "" if ms is None else "%.0f" % ms if ms >= 100 else "%.1f" % ms


def cell(record, program, key):
    ms, ratio = median(record, program, key), ratios(record, program, key)
    if ms is None:
        return ""
    return "%s (%.1fx)" % (number(ms), ratio[0]) if ratio else number(ms)


def geometric(values):
    values = [v for v in values if v]
    return math.exp(sum(map(math.log, values)) / len(values)) if values else None


def label(record):
    return "%s%s, %dx%d" % (record["scene"], ", shaded" if record["shade"] else "", *record["size"])


def reached(record, result):
    """Samples a second of the drawn frames over the machine's own limit for that kind of sample, in percent."""
    kind = record["kind"] + ("_shade" if record["shade"] else "")
    best = max((x["samples_per_second"].get(kind, 0) for x in result.get("limit", [])), default=0)
    taken = [run.get("samples_taken") for run in record["runs"].get("pellucid", [])]
    ms = median(record, "pellucid", "frame_ms")
    if not best or not ms or not taken or taken[0] is None:
        return ""
    return "%.0f%%" % (100 * taken[0] / (ms / 1e3) / best)


def block(result, records, key, programs, limit=False):
    """One table of milliseconds, a row a scene, the ratio to ours beside each peer's."""
    programs = [p for p in programs if any(median(r, p, key) for r in records)]
    records = [r for r in records if median(r, "pellucid", key)]
    if not records:
        return ""
    limit = limit and any(reached(r, result) for r in records)
    soft = any("llvmpipe" in run.get("gl", "") for r in records for run in r["runs"].get("vtk-gpu", []))
    names = [HEADINGS[p] + (", llvmpipe" if soft and p == "vtk-gpu" else "") for p in programs]
    lines = ["| scene | Pellucid | " + "".join(n + " | " for n in names) + ("of the limit | " if limit else "")]
    lines.append("| --- |" + " ---: |" * (1 + len(programs) + limit))
    for r in records:
        lines.append("| %s | %s | " % (label(r), number(median(r, "pellucid", key))) + "".join(cell(r, p, key) + " | " for p in programs)
                     + (reached(r, result) + " | " if limit else ""))
    means = [geometric([(ratios(r, p, key) or [None])[0] for r in records]) for p in programs]
    if len(records) > 1 and any(means):
        lines.append("| geometric mean | | " + "".join(("%.1fx | " % m if m else "| ") for m in means) + ("| " if limit else ""))
    return "\n".join(line.rstrip() for line in lines) + "\n"


def beside_volpack(records, program, name):
    """VolPack, which has one thread, beside a program of ours on all processors and on one; a frame, and after a changed transfer function."""
    rows = []
    for r in records:
        ours = [median(r, program, key) for key in ("frame_ms", "edit_ms")]
        alone = median(r, program + "-1", "frame_ms")
        theirs = [median(r, "volpack", key) for key in ("frame_ms", "edit_ms", "reclassify_ms")]
        if all(ours + theirs) and alone:
            compared = [theirs[0] / ours[0], theirs[0] / alone, theirs[1] / ours[1], theirs[2] / ours[1]]
            rows.append((label(r), number(ours[0]), "%s (%.1fx)" % (number(theirs[0]), compared[0]), "%s (%.1fx)" % (number(alone), compared[1]), number(ours[1]),
                         "%s (%.1fx)" % (number(theirs[1]), compared[2]), "%s (%.1fx)" % (number(theirs[2]), compared[3]), compared))
    if not rows:
        return ""
    lines = ["| scene | %s, a frame | VolPack | %s on one thread | %s, after a change | VolPack from raw voxels | VolPack, classified again |" % (name, name, name),
             "| --- |" + " ---: |" * 6]
    lines += ["| %s | %s | %s | %s | %s | %s | %s |" % row[:7] for row in rows]
    lines.append("| geometric mean | | %.1fx | %.1fx | | %.1fx | %.1fx |" % tuple(geometric([row[7][i] for row in rows]) for i in range(4)))
    return "\n".join(lines) + "\n"


def gpu_engine(records):
    """The GPU engine beside VTK's mapper on the same device."""
    rows, device = [], ""
    for r in records:
        ours = [median(r, "pellucid-gpu", key) for key in ("frame_ms", "edit_ms")]
        theirs = [median(r, "vtk-gpu", key) for key in ("frame_ms", "edit_ms")]
        if all(ours):
            device = r["runs"]["pellucid-gpu"][0].get("device", "")
            compared = [t / o if t else None for t, o in zip(theirs, ours)]
            rows.append((label(r), number(ours[0]), "%s (%.1fx)" % (number(theirs[0]), compared[0]) if theirs[0] else "", number(ours[1]),
                         "%s (%.1fx)" % (number(theirs[1]), compared[1]) if theirs[1] else "", compared))
    if not rows:
        return ""
    lines = ["On %s." % device, "", "| scene | Pellucid, a frame | VTK GPU mapper | after a change | VTK |", "| --- |" + " ---: |" * 4]
    lines += ["| %s | %s | %s | %s | %s |" % row[:5] for row in rows]
    means = [geometric([row[5][i] for row in rows]) for i in range(2)]
    if all(means):
        lines.append("| geometric mean | | %.1fx | | %.1fx |" % tuple(means))
    return "\n".join(lines) + "\n"


def stills(records):
    rows = []
    for r in records:
        if not r["stills"].get("pellucid"):
            continue
        ours = [statistics.median(x[i] for x in r["stills"]["pellucid"]) for i in (0, 1)]
        row = "| %s | %s | %.0f MB |" % (label(r), number(ours[0]), ours[1])
        if r["stills"].get("vtk-cpu"):
            vtk = [statistics.median(x[i] for x in r["stills"]["vtk-cpu"]) for i in (0, 1)]
            row += " %s (%.1fx) | %.0f MB |" % (number(vtk[0]), vtk[0] / ours[0], vtk[1])
        else:
            row += " | |"
        rows.append(row + " %.0f MB |" % r["volume_mb"])
    if not rows:
        return ""
    return "| scene | Pellucid, ms | peak memory | VTK in Python, ms | peak memory | the volume |\n| --- |" + " ---: |" * 5 + "\n" + "\n".join(rows) + "\n"


def about(result):
    m, versions = result["machine"], {}
    for r in result["scenes"]:
        for name, runs in r["runs"].items():
            versions.setdefault(name, runs[0])
    ours, vtk = versions.get("pellucid", {}), versions.get("vtk-cpu") or versions.get("vtk-iso") or versions.get("vtk-gpu") or {}
    lines = ["%s, %d cores, %s. `%s`: milliseconds, medians of %d rounds of %d frames; in brackets how many times as long as Pellucid."
             % (m["cpu"], m["cores"], result["date"][:10], result["command"], result["rounds"], result["frames"])]
    if ours.get("isa"):
        lines.append("Pellucid's kernels: %s." % ours["isa"])
    if vtk:
        lines.append("VTK %s on %s." % (vtk["version"], vtk["gl"]))
    return " ".join(lines) + "\n"


def table(result):
    scenes = result["scenes"]
    rays, iso = [r for r in scenes if r["kind"] != "iso"], [r for r in scenes if r["kind"] == "iso"]
    peers = ["vtk-cpu", "vtk-gpu", "volpack"]
    parts = [
        ("", about(result)),
        ("A frame, the camera turning", block(result, rays, "frame_ms", peers, limit=True)),
        ("A frame after the transfer function changed", block(result, rays, "edit_ms", peers)),
        ("An isosurface, the isovalue changing each frame", block(result, iso, "edit_ms", ["vtk-iso"])),
        ("An isosurface, the camera turning", block(result, iso, "frame_ms", ["vtk-iso"], limit=True)),
        ("The GPU engine, the camera turning and the transfer function (isovalue) changing", gpu_engine(scenes)),
        ("VolPack's own number of rays: in parallel, one a voxel", beside_volpack(scenes, "pellucid-rays", "raycast")),
        ("Shear-warp beside shear-warp", beside_volpack(scenes, "pellucid-shear", "slices2d")),
        ("From process start to a PNG on disk, and peak memory", stills(scenes)),
    ]
    return "\n".join(("**%s**\n\n" % title if title else "") + text for title, text in parts if text)


def fill_readme(text):
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "README.md")
    with open(path, encoding="utf-8") as f:
        old = f.read()
    begin, end = "<!-- bench: begin -->\n", "<!-- bench: end -->"
    head, rest = old.split(begin)
    tail = rest.split(end)[1]
    with open(path, "w", encoding="utf-8") as f:
        f.write(head + begin + text + end + tail)


if __name__ == "__main__":
    with open(sys.argv[-1], encoding="utf-8") as source:
        made = table(json.load(source))
    if "--readme" in sys.argv:
        fill_readme(made)
    else:
        print(made)
