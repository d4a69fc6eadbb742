#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Shader texts: composed as the program does, with no GPU, and each variant put before glslang.  Usage: check_shaders.py COMPOSE FOLDER"""
import itertools
import os
import re
import shutil
import subprocess
import sys
import tempfile

compose, scratch = sys.argv[1], sys.argv[2]
passed, failed = 0, 0


def check(good, name, told=""):
    global passed, failed
    passed, failed = passed + bool(good), failed + (not good)
    print("%s %d - %s%s" % ("ok" if good else "not ok", passed + failed, name, "" if good else ": " + str(told)))


def text(name, defines="", folder=None):
    env = dict(os.environ)
    env.pop("PELLUCID_SHADERS", None)
    if folder:
        env["PELLUCID_SHADERS"] = folder
    return subprocess.run([compose, name, defines], capture_output=True, text=True, env=env, check=False)


files = subprocess.run([compose], capture_output=True, text=True, check=True).stdout.split()
texts = {name: text(name).stdout for name in files}
roots = [name for name in files if "void main()" in texts[name] and name != "march.glsl"]  # which wants a filling


def stage(name):
    """A drawing program's shaders say in their names what they are; all others compute."""
    return "vert" if name.endswith("_vertex.glsl") else "geom" if name.endswith("_geometry.glsl") else "frag" if name.endswith("_fragment.glsl") else "comp"


for wanted, least in (("comp", 10), ("vert", 3), ("frag", 8)):
    check(sum(stage(name) == wanted for name in roots) >= least, "programs are found: " + wanted, roots)
for name in roots:
    own = texts[name]
    check("#include" not in own.replace("// ", ""), name + ": every include is replaced")
    check(own.startswith("#version 450 core\n") and own.count("layout(std140, binding = 0)") <= 1, name + ": the version first, each file once")
check("there is no shader file" in text("none.glsl").stderr, "a missing file is named", text("none.glsl").stderr)

# A folder takes the place of embedded files; a missing or endless include is told with its place.
with tempfile.TemporaryDirectory(dir=scratch) as folder:
    with open(os.path.join(folder, "slice.glsl"), "w", encoding="utf-8") as f:
        f.write("// another\n#include \"nowhere.glsl\"\n")
    told = text("slice.glsl", "", folder).stderr
    check("slice.glsl:2" in told and "nowhere.glsl" in told, "the place of a missing include", told)
    with open(os.path.join(folder, "slice.glsl"), "w", encoding="utf-8") as f:
        f.write("// another\n")
    check("// another" in text("slice.glsl", "", folder).stdout, "a folder overrides")

glslang = shutil.which("glslangValidator")
common = ["", "BRICKS", "BRICKS VOIDS SHADE", "BRICKS NEAREST HEADLIGHTS SHADE", "VOIDS", "NEAREST", "SHADE", "HEADLIGHTS SHADE", "NEAREST SHADE", "VOIDS SHADE HEADLIGHTS"]
own = {"composite.glsl": ["PRE", "PRE SHADE HEADLIGHTS VOIDS", "PRE BRICKS"], "extreme.glsl": ["MINIMUM", "MINIMUM VOIDS", "MINIMUM BRICKS"],
       "slice_fragment.glsl": ["PREINTEGRATED SHADE", "PRE EARLY_OUT", "BAND EARLY_OUT SHADE", "PREINTEGRATED VOIDS BAND", "NEAREST SHADE VOIDS HEADLIGHTS"],
       "half_fragment.glsl": ["PREINTEGRATED", "PRE"], "opaque_fragment.glsl": ["PREINTEGRATED"], "cube_fragment.glsl": ["SHOW"],
       "stop_fragment.glsl": ["GREATER"], "histopyramid_sum.glsl": ["BASE"], "stretch_fragment.glsl": ["BAND"], "plain_fragment.glsl": ["BAND"],
       "mesh_fragment.glsl": ["LIST", "LIST HEADLIGHTS"], "mesh_depth.glsl": ["LIST"],
       "peel_vertex.glsl": ["DISC"], "peel_fragment.glsl": ["DISC"], "peel_masks.glsl": ["DISC"],
       "peel_cast.glsl": ["STEPPING", "STEPPING BINARY_SEARCH VOIDS", "EXTERIOR", "EXTERIOR STEPPING HEADLIGHTS", "WHOLE VOIDS", "WHOLE STEPPING", "TREE", "TREE STEPPING VOIDS", "LISTED", "LISTED STEPPING VOIDS", "ONE_ISOVALUE", "ONE_ISOVALUE STEPPING VOIDS"],
       "isosurface_cells.glsl": ["ONE_ISOVALUE", "ONE_ISOVALUE BRICKS VOIDS"], "isosurface.glsl": ["ONE_ISOVALUE HEADLIGHTS"],
       "classify.glsl": ["MODE=%d MODE_MIP=1 MODE_MINIP=2 MODE_ISOSURFACE=5" % mode for mode in (0, 1, 2, 5)]}
slices = ["AXIS=%d LIGHTING=%d" % (axis, axis) for axis in (0, 1, 2)] + ["AXIS=1 LIGHTING=0 " + d for d in (
    "VOIDS SHADE HEADLIGHTS", "NEAREST SHADE DEPTH", "PLAIN SHADE HEADLIGHTS", "PLAIN VOIDS", "PRE VOIDS SHADE", "PRE LINEAR_CORRECTION", "LINEAR_CORRECTION DISPLACED",
    "ALPHA_TEST PLAIN DEPTH", "ALPHA_TEST VOIDS HEADLIGHTS", "ONE_ISOVALUE", "DEPTH")]
own.update({n: slices for n in roots if n.startswith("slices2d_")})
for name, defines in itertools.chain(((n, d) for n in roots for d in common if n != "classify.glsl" and not n.startswith("slices2d_")), ((n, d) for n, ds in own.items() for d in ds)):
    if not glslang:
        continue
    source = text(name, defines).stdout
    result = subprocess.run([glslang, "--stdin", "-S", stage(name)], input=source, capture_output=True, text=True, check=False)
    check(result.returncode == 0, "glslang: %s %s" % (name, defines), result.stdout)
if glslang:  # the block that C fills is the block that shaders read
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../src/render/gpu/gpu_job.c"), encoding="utf-8") as f:
        size = int(re.search(r"JOB_BYTES = (\d+)", f.read()).group(1))
    whole = os.path.join(scratch, "block.comp")
    with open(whole, "w", encoding="utf-8") as f:
        f.write(text("composite.glsl", "BRICKS").stdout)
    told = subprocess.run([glslang, "-q", "-l", "-S", "comp", whole], capture_output=True, text=True, check=False).stdout
    last = re.search(r"JobBlock\.own_hi: offset (\d+)", told)
    check(last and int(last.group(1)) + 16 == size, "struct job is as large as JobBlock", last)
if not glslang:
    print("ok %d - glslang # SKIP there is no glslangValidator; install glslang-tools" % (passed + failed + 1))
    passed += 1
print("1..%d" % (passed + failed))
sys.exit(1 if failed else 0)
