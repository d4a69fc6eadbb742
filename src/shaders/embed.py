#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes shader files into a C file as the list that shader_source.h declares.  Usage: embed.py OUT.c FILE.glsl ..."""
import os
import sys


def literal(text):
    lines = [line.replace("\\", "\\\\").replace('"', '\\"') for line in text.splitlines()]
    return "\n".join('        "%s\\n"' % line for line in lines)


files = sorted(sys.argv[2:], key=os.path.basename)
with open(sys.argv[1], "w", encoding="utf-8") as out:
    out.write('/* Made by embed.py from the .glsl files. */\n#include "shader_source.h"\n\nconst struct pel_shader_file pel_shader_files[] = {\n')
    for path in files:
        with open(path, encoding="utf-8") as f:
            out.write('    { "%s",\n%s },\n' % (os.path.basename(path), literal(f.read())))
    out.write("};\nconst size_t pel_shader_file_count = sizeof pel_shader_files / sizeof *pel_shader_files;\n")
