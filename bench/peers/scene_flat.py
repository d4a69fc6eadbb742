# SPDX-License-Identifier: MIT
"""Prints one scene as plain lines, for the C program: python3 scene_flat.py SCENE [FRAMES] | ./volpack_dvr ..."""
import json, os, sys

with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "scenes.json"), encoding="utf-8") as f:
    doc = json.load(f)
scene = next(s for s in doc["scenes"] if s["name"] == sys.argv[1])
frames = int(sys.argv[2]) if len(sys.argv) > 2 else doc["frames"]
vol, cam, light = doc["volumes"][scene["volume"]], scene["camera"], doc["shading"]
root = os.environ.get("PEERS_DATA") or sys.exit("set PEERS_DATA to the folder that holds the .raw volumes")


def row(key, *values):
    print(key, *values)


row("name", scene["name"])
row("file", os.path.join(root, scene["volume"] + ".raw"))
row("dims", *vol["dims"])
row("spacing", *vol["spacing"])
row("unit", doc["unit_distance"])
row("size", *scene["size"])
row("position", *cam["position"])
row("focal", *cam["focal"])
row("up", *cam["up"])
row("angle", cam["view_angle"])
row("shading", *(light[k] for k in ("ambient", "diffuse", "specular", "power")))
row("orbit", doc["orbit_degrees"], doc["warmup"], frames)
for key, width in (("opacity", 2), ("color", 4)):
    row(key, len(scene[key]), *(x for p in scene[key] for x in p[:width]))
