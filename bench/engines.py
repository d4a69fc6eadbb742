#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""How far the GPU engine's pictures are from the CPU engine's: every volume of a folder in every mode, and the least PSNR of each mode.

  bench/engines.py [--build FOLDER] [--device gpu] [--size 256] [--modes mip,xray] [--picture FILE.png] [VOLUME ...]

Each picture is what `pellucid render VOLUME --mode MODE` chooses by itself, drawn with --device cpu and with --device gpu as float NRRD and put before `pellucid compare`. Without names the
volumes are all that can be read in PELLUCID_DATA, or in ../shared/data beside the checkout. --picture draws the volumes small, nine in a row: by the CPU, below it by the GPU, and
64 times their difference (docs/gallery/engines.png).
"""
import argparse
import array
import json
import os
import struct
import subprocess
import sys
import tempfile
import zlib

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
MODES = ["composite", "mip", "minip", "average", "xray", "isosurface", "slice"]
TILE, COLUMNS, MAGNIFIED = 122, 9, 64  # pixels a side; volumes in a row; of the difference


def pellucid(args, *words):
    return subprocess.run([os.path.join(args.build, "tools", "pellucid")] + list(words), capture_output=True, text=True, check=False)


def draw(args, volume, device, size, path, *more):
    result = pellucid(args, "render", volume, "-o", path, "--device", device, "--size", str(size), "--quiet", *more)
    if result.returncode:
        sys.exit("engines: %s" % result.stderr.strip())


def volumes(args):
    """Those named, or what can be read in the folder."""
    if args.volumes:
        return args.volumes
    folder = os.environ.get("PELLUCID_DATA") or os.path.join(ROOT, "..", "shared", "data")
    if not os.path.isdir(folder):
        sys.exit("engines: no data: name volumes, or set PELLUCID_DATA to a folder of them")
    paths = [os.path.join(folder, name) for name in sorted(os.listdir(folder), key=str.lower)]
    return [path for path in paths if pellucid(args, "info", "--json", path).returncode == 0]


def read_float_nrrd(path):
    """RGBA of a picture that `pellucid render` wrote."""
    with open(path, "rb") as f:
        data = f.read()
    values = array.array("f", data[data.index(b"\n\n") + 2:])
    if sys.byteorder == "big":
        values.byteswap()
    return values


def write_png(path, width, rows):
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    lines = (b"\1" + bytes((a - b) & 255 for a, b in zip(row, b"\0\0\0" + row)) for row in rows)  # differences along the row
    with open(path, "wb") as f:
        f.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, len(rows), 8, 2, 0, 0, 0)) +
                chunk(b"IDAT", zlib.compress(b"".join(lines), 9)) + chunk(b"IEND", b""))


def side_by_side(args, paths, folder):
    """Rows of bytes: the volumes by the CPU, by the GPU, and the magnified difference."""
    rows = [bytearray() for _ in range(3 * TILE * (1 + (len(paths) - 1) // COLUMNS))]
    for number, path in enumerate(paths):
        pictures = []
        for device in ["cpu", args.device]:
            draw(args, path, device, TILE, os.path.join(folder, "small.nrrd"))
            pictures.append(read_float_nrrd(os.path.join(folder, "small.nrrd")))
        cpu, gpu = pictures
        for y in range(TILE):
            for x in range(TILE):
                at = 4 * (y * TILE + x)
                for part, colour in enumerate([cpu[at:at + 3], gpu[at:at + 3], [MAGNIFIED * abs(a - b) for a, b in zip(cpu[at:at + 3], gpu[at:at + 3])]]):
                    rows[(3 * (number // COLUMNS) + part) * TILE + y] += bytes(max(0, min(255, int(255 * c + 0.5))) for c in colour)
    width = max(len(row) for row in rows)
    return [bytes(row.ljust(width, b"\0")) for row in rows]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default=os.path.join(ROOT, "build"))
    parser.add_argument("--device", default="gpu")
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--modes", default=",".join(MODES))
    parser.add_argument("--picture")
    parser.add_argument("volumes", nargs="*")
    args = parser.parse_args()
    paths = volumes(args)
    with tempfile.TemporaryDirectory() as folder:
        names = [os.path.join(folder, device + ".nrrd") for device in ("cpu", "gpu")]
        if args.picture:
            rows = side_by_side(args, paths, folder)
            write_png(args.picture, len(rows[0]) // 3, rows)
        found = {}
        for mode in filter(None, args.modes.split(",")):
            for path in paths:
                for name, device in zip(names, ["cpu", args.device]):
                    draw(args, path, device, args.size, name, "--mode", mode)
                told = json.loads(pellucid(args, "compare", *names, "--json").stdout)
                found.setdefault(mode, []).append((told["psnr"], told["max_error"], os.path.basename(path)))
                print("%-11s %-28s %6.1f dB, greatest difference %.6f" % (mode, os.path.basename(path), told["psnr"], told["max_error"]), flush=True)
        print("\nleast PSNR of %d volumes, %dx%d:" % (len(paths), args.size, args.size))
        for mode, results in found.items():
            results.sort()
            print("%-11s %6.1f dB (%s)%s" % (mode, results[0][0], results[0][2],
                                             "; next %.1f dB (%s)" % (results[1][0], results[1][2]) if len(results) > 1 else ""))


main()
