#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Whether culling changes a picture: slices3d with each --cull against none, over every volume of a folder, from 26 directions.

  bench/culling.py [--build FOLDER] [--device gpu] [--size 128] [--step 1] [--ways ess,band] [--bands] [--turned] [--out FILE.md] [VOLUME ...]

The directions are those of a cube's faces, edges and corners, in perspective and in parallel; with --turned all of them 30 degrees round and 20 up, so that none lies along an axis. Each picture is what `pellucid render VOLUME` chooses by itself; with --bands the opacity is an
adversarial curve over the volume's values instead: opaque shells inside translucent ones, with nothing between them. Pictures are float, and the greatest difference of any channel is told in
1/255. Without names the volumes are all that can be read in PELLUCID_DATA, or in ../shared/data beside the checkout. --out writes the table as Markdown, with the command, renderer and date; it is
written anew after each volume, so that a run that is cut short leaves what it found. It measures no time.
"""
import argparse
import array
import datetime
import json
import os
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
WAYS = ["front", "err", "ess", "ert", "ess+ert", "band"]
PROJECTIONS = {"perspective": [], "parallel": ["--parallel"]}
# The camera that is chosen stands 30 degrees round and 20 up (camera.h): from there back to the axis.
ROUND, UP = 30, 20
# Turntables: pictures in a turn, azimuth of the first, elevation. Corners of a cube stand at atan(1 / sqrt 2), edges at 45 degrees.
TURNS = [(8, 0, 0), (4, 0, 45), (4, 0, -45), (4, 45, 35.26439), (4, 45, -35.26439), (1, 0, 90), (1, 0, -90)]


def pellucid(args, *words):
    return subprocess.run([os.path.join(args.build, "tools", "pellucid")] + list(words), capture_output=True, text=True, check=False)


def volumes(args):
    """Paths with what is known of them: those named, or what can be read in the folder."""
    folder = os.environ.get("PELLUCID_DATA") or os.path.join(ROOT, "..", "shared", "data")
    if not args.volumes and not os.path.isdir(folder):
        sys.exit("culling: no data: name volumes, or set PELLUCID_DATA to a folder of them")
    paths = args.volumes or [os.path.join(folder, name) for name in sorted(os.listdir(folder), key=str.lower)]
    told = [(path, pellucid(args, "info", "--json", path)) for path in paths]
    return [(path, json.loads(result.stdout)) for path, result in told if result.returncode == 0]


def bands(info):
    """Opacity over the volume's values: translucent, nothing, opaque, nothing, faint, opaque in a sliver, opaque, faint."""
    points = [(0, 0), (0.06, 0), (0.07, 0.05), (0.16, 0.05), (0.17, 0), (0.2, 0), (0.21, 1), (0.5, 1), (0.51, 0), (0.56, 0), (0.57, 0.1), (0.6, 0.1), (0.61, 1), (0.62, 1), (0.63, 0.1), (0.68, 0.3),
              (0.7, 0.9), (0.9, 1), (0.91, 0.02), (1, 0.02)]
    lo, hi = info["min"], info["max"]
    return ",".join("%.9g:%g" % (lo + at * (hi - lo), opacity) for at, opacity in points)


def draw(args, path, folder, turn, words):
    """The turn's pictures as bytes, and what drew them."""
    count, azimuth, elevation = turn
    result = pellucid(args, "render", path, "-o", os.path.join(folder, "p.nrrd"), "--technique", "slices3d", "--device", args.device, "--size", str(args.size), "--step", str(args.step), "--quiet",
                      "--turntable", str(count), "--azimuth", str(azimuth - (0 if args.turned else ROUND)), "--elevation", str(elevation - (0 if args.turned else UP)), "--stats", "json", *words)
    if result.returncode:
        sys.exit("culling: %s" % result.stderr.strip())
    pictures = []
    for i in range(count):
        with open(os.path.join(folder, "p_%04d.nrrd" % i), "rb") as f:
            data = f.read()
        pictures.append(data[data.index(b"\n\n") + 2:])
    return pictures, json.loads(result.stdout)["device"]


def difference(a, b):
    """The greatest of two float pictures, in 1/255."""
    if a == b:
        return 0.0
    x, y = array.array("f", a), array.array("f", b)
    return 255 * max(abs(p - q) for p, q in zip(x, y))


def compare(args, path, info, folder):
    """The greatest difference of each way over directions and projections, how many pictures are equal to the last bit, how many show nothing, and the device."""
    most, equal, blank, device = {way: 0.0 for way in args.ways}, 0, 0, ""
    words = ["--opacity", bands(info)] if args.bands else []
    for projection, more in PROJECTIONS.items():
        for turn in TURNS:
            whole, device = draw(args, path, folder, turn, words + more + ["--cull", "none"])
            blank += sum(not any(picture) for picture in whole)
            for way in args.ways:
                for number, (a, b) in enumerate(zip(whole, draw(args, path, folder, turn, words + more + ["--cull", way])[0])):
                    apart = difference(a, b)
                    equal += apart == 0
                    most[way] = max(most[way], apart)
                    if apart > 1:
                        print("%s %s, %s, picture %d of turn %s: %.3f / 255" % (os.path.basename(path), way, projection, number, turn, apart), flush=True)
    return most, equal, blank, device


def table(args, found, device):
    lines = ["Greatest difference of slices3d's pictures with each `--cull` from those with `--cull none`, in 1/255: 26 directions%s, "
             "perspective and parallel, %s. %s, on %s. `bench/culling.py%s`" % (
                 " turned off the axes" if args.turned else "", "an adversarial transfer function of bands" if args.bands else "each volume's own transfer function", datetime.date.today(), device, args.told), "",
             "| volume | %s | equal to the last bit |" % " | ".join(args.ways), "| --- |%s ---: |" % (" ---: |" * len(args.ways))]
    for name, (most, equal, blank, _) in found.items():
        if blank:
            name += " (%d of 52 blank)" % blank
        lines.append("| %s | %s | %d of %d |" % (name, " | ".join("%.4f" % most[way] if most[way] else "0" for way in args.ways), equal, 52 * len(args.ways)))
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default=os.path.join(ROOT, "build"))
    parser.add_argument("--device", default="gpu")
    parser.add_argument("--size", type=int, default=128)
    parser.add_argument("--step", type=float, default=1)
    parser.add_argument("--ways", type=lambda text: text.split(","), default=WAYS, help="of culling: " + ",".join(WAYS))
    parser.add_argument("--bands", action="store_true")
    parser.add_argument("--turned", action="store_true")
    parser.add_argument("--out")
    parser.add_argument("volumes", nargs="*")
    args = parser.parse_args()
    args.told = " --size %d --step %g%s%s%s" % (args.size, args.step, " --bands" if args.bands else "", " --turned" if args.turned else "", "" if args.ways == WAYS else " --ways " + ",".join(args.ways))
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for path, info in volumes(args):
            result = compare(args, path, info, folder)
            found[os.path.basename(path)] = result
            print("%-26s %s" % (os.path.basename(path), ", ".join("%s %.4f" % pair for pair in result[0].items())), flush=True)
            if args.out:
                with open(args.out, "w", encoding="utf-8") as f:
                    f.write(table(args, found, result[3]))
    if not found:
        sys.exit("culling: none of these can be read")
    worst = max((max(most.values()), name) for name, (most, _, _, _) in found.items())
    print("greatest of %d volumes: %.3f / 255 (%s)" % (len(found), *worst))
    sys.exit(worst[0] > 1)


main()
