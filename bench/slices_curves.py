#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws the curves of the paper's figures 14 and 15 (Rezk-Salama et al. 2000) with this program's slices2d on the GPU engine, as SVG.

  bench/slices_curves.py --build FOLDER VOLUME [--size N] [--rounds N] [--frames N] [--device gpu] [--out FOLDER]

Figure 14: frames a second against the number of slices, with 1, 2, 4 and 8 slices a polygon, (A) unshaded and (B) shaded. Figure 15: against
supersampling, for volumes unshaded and shaded and for isosurfaces. Each round visits every point once, in an order that turns from round to round; a
point is the median of its rounds' median frames. All is written to slices2d.json, too, with the ratio of the best n to n = 1 at each point.
"""
import argparse
import json
import os
import statistics
import subprocess

SAMPLINGS = [(1, 4), (1, 2), (1, 1), (2, 1), (4, 1)]  # supersampling, slice-step
COLORS = ["#0b5394", "#cc4125", "#6aa84f", "#8e7cc3"]


def frame_ms(args, extra):
    command = [os.path.join(args.build, "tools", "pellucid"), "bench", args.volume, "--technique", "slices2d", "--device", args.device, "--size", str(args.size),
               "--frames", str(args.frames), "--warmup", "1", "--json"] + extra
    return json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)["frame_ms"]["median"]


def points(figures):
    """(figure, line, x, flags) of everything that is measured."""
    shading = {"A": ["--no-shade"], "B": ["--shade"]}
    for part in figures:
        for n in (1, 2, 4, 8):
            for over, step in SAMPLINGS:
                yield ("14" + part, "n = %d" % n, over / step,
                       shading[part] + ["--slices-per-polygon", str(n), "--supersampling", str(over), "--slice-step", str(step)])
    kinds = {"unshaded": ["--no-shade"], "shaded": ["--shade"], "isosurface": ["--mode", "isosurface"]}
    for kind, flags in kinds.items():
        for over in (1, 2, 3, 5, 7, 10):
            yield "15", kind, over * 100, flags + ["--slices-per-polygon", "8", "--supersampling", str(over)]


def svg(title, x_label, lines):
    """Frames a second over x, both from 0."""
    width, height, left, top, right, bottom = 560, 360, 60, 36, 110, 48
    most_x, most_y = max(x for line in lines.values() for x, _ in line), max(y for line in lines.values() for _, y in line) * 1.05
    across, up = width - left - right, height - top - bottom
    text = ['<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 %d %d" font-family="sans-serif" font-size="12">' % (width, height),
            '<rect width="100%" height="100%" fill="white"/>', '<text x="%d" y="20" font-size="14">%s</text>' % (left, title)]
    for i in range(6):
        x, y = most_x * i / 5, most_y * i / 5
        text.append('<path d="M%.1f %.1f h%d" stroke="#ddd"/><text x="%d" y="%.1f" text-anchor="end">%.3g</text>'
                    % (left, top + up - up * i / 5, across, left - 6, top + up - up * i / 5 + 4, y))
        text.append('<text x="%.1f" y="%d" text-anchor="middle">%.4g</text>' % (left + across * i / 5, top + up + 18, x))
    text.append('<text x="%d" y="%d" text-anchor="middle">%s</text>' % (left + across / 2, height - 10, x_label))
    text.append('<text x="14" y="%d" transform="rotate(-90 14 %d)" text-anchor="middle">frames a second</text>' % (top + up / 2, top + up / 2))
    for (name, line), color in zip(lines.items(), COLORS):
        at = [(left + across * x / most_x, top + up - up * y / most_y) for x, y in sorted(line)]
        text.append('<polyline fill="none" stroke="%s" stroke-width="2" points="%s"/>' % (color, " ".join("%.1f,%.1f" % p for p in at)))
        text.extend('<circle cx="%.1f" cy="%.1f" r="3" fill="%s"/>' % (x, y, color) for x, y in at)
    for i, (name, color) in enumerate(zip(lines, COLORS)):
        text.append('<text x="%d" y="%d" fill="%s">%s</text>' % (left + across + 12, top + 14 + 18 * i, color, name))
    return "\n".join(text + ["</svg>", ""])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("volume")
    parser.add_argument("--build", default="build")
    parser.add_argument("--size", type=int, default=600, help="the paper's viewport is 600 x 600")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--frames", type=int, default=3)
    parser.add_argument("--device", default="gpu")
    parser.add_argument("--only", default="AB", help="parts of figure 14")
    parser.add_argument("--out", default=".")
    args = parser.parse_args()
    todo, measured = list(points(args.only)), {}
    for i in range(args.rounds):
        turn = i * len(todo) // args.rounds
        for figure, line, x, flags in todo[turn:] + todo[:turn]:
            measured.setdefault((figure, line, x), []).append(frame_ms(args, flags))
    ms = {key: statistics.median(values) for key, values in measured.items()}
    info = subprocess.run([os.path.join(args.build, "tools", "pellucid"), "info", args.volume, "--json"], capture_output=True, text=True, check=True)
    slices = max(json.loads(info.stdout)["dims"])
    os.makedirs(args.out, exist_ok=True)
    titles = {"14A": "Slices a polygon, unshaded", "14B": "Slices a polygon, shaded", "15": "Supersampling, 8 slices a polygon"}
    for figure in sorted({key[0] for key in ms}):
        lines = {}
        for (f, line, x), value in ms.items():
            if f == figure:
                lines.setdefault(line, []).append((x * slices if figure != "15" else x, 1000 / value))
        with open(os.path.join(args.out, "slices2d_%s.svg" % figure), "w", encoding="utf-8") as out:
            out.write(svg(titles[figure], "supersampling, per cent" if figure == "15" else "slices along the longest axis", lines))
    ratios = {"%s x %g" % (f, x): max(ms[f, "n = 1", x] / ms[f, "n = %d" % n, x] for n in (2, 4, 8)) for f, line, x in ms if line == "n = 1"}
    with open(os.path.join(args.out, "slices2d.json"), "w", encoding="utf-8") as out:
        json.dump({"volume": os.path.basename(args.volume), "size": args.size, "rounds": args.rounds, "frames": args.frames,
                   "frame_ms": {" ".join(map(str, key)): value for key, value in ms.items()}, "best_n_over_one": ratios}, out, indent=1)
    for name, ratio in ratios.items():
        print("figure %s slices a slice of voxels: best n over n = 1: %.2f" % (name, ratio))


if __name__ == "__main__":
    main()
