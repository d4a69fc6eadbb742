#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes files as bytes into a C file, as the list that web_files.h declares.  Usage: embed.py OUT.c FILE ..."""
import os
import sys

files = sorted(sys.argv[2:], key=os.path.basename)
with open(sys.argv[1], "w", encoding="ascii") as out:
    out.write('/* Made by embed.py. */\n#include "web_files.h"\n')
    rows = []
    for number, path in enumerate(files):
        with open(path, "rb") as file:
            data = file.read()
        out.write("static const unsigned char file_%d[] = {\n" % number)
        for at in range(0, len(data), 32):
            out.write("    " + " ".join("%d," % byte for byte in data[at:at + 32]) + "\n")
        out.write("    0\n};\n")
        rows.append('    { "%s", file_%d, %d },\n' % (os.path.basename(path), number, len(data)))
    out.write("const struct web_file web_files[] = {\n%s    { 0, 0, 0 },\n};\n" % "".join(rows))
