# SPDX-License-Identifier: MIT
"""Each option of the tables with values at its limits, beyond them and of no sense: status 0, 1 or 2, one line of error, never a crash, and no
picture where the status is not 0. The options come from the help, so a new one is tested at once."""
import os
import re

from harness import Folder, check, fine, finish, options_of, run

JUNK = ["", "0", "-1", "1", "1e308", "-1e308", "1e999", "nan", "99999999999999999999", "1,2", "0,0,0", "1,2,3,4,5,6", "nan,nan,nan",
        "1e308,1e308,1e308", "1,1,1e300", ",", "%s%n", "\xe9\u4e2d", "#fff", "../x", "true", "-", "A" * 5000]
# What would only be slow or large, not wrong.
SIZES = ["", "0", "1", "1x1", "3x", "x3", "32768x1", "1x32768", "32769", "99999999999x1", "-1x5", "nan", "1e3", "7X9", "5x5x5"]
OWN = {"size": SIZES, "turntable": ["0", "1", "2", "10000", "-1", "nan", ""], "frames": ["0", "1", "2", "1001", "-1", "nan"],
       "warmup": ["0", "1", "1001", "-1", "nan"], "threads": ["0", "1", "2", "64", "1025", "-1", "nan"], "help": []}


# Thousands of tiny runs: threads would only wait for one another.
ENVIRONMENT = dict(os.environ, OMP_NUM_THREADS="1")


def values_of(name, facts):
    if name in OWN:
        return OWN[name]
    values = list(JUNK)
    limits = re.search(r"([-+.e0-9]+) to ([-+.e0-9]+)", facts)
    if limits:
        low, high = float(limits.group(1)), float(limits.group(2))
        for value in (low, high, low - abs(low) * 0.01 - 1e-9, high + abs(high) * 0.01 + 1e-9):
            values += ["%.17g" % value, ",".join(["%.17g" % value] * 3)]
    choices = re.search(r"\[((?:\w+, )+\w+);", facts)
    if choices:
        values += choices.group(1).split(", ")
    return values


def hammer(command, words, name, value, output, folder):
    result = run(*command, "--%s=%s" % (name, value), *words, cwd=folder.path, env=ENVIRONMENT)
    good = result.status in (0, 1, 2) and "Sanitizer" not in result.err and "runtime error" not in result.err
    if result.status in (1, 2):
        good = good and result.one_error() and not os.path.exists(folder / output)
    if os.path.exists(folder / output):
        os.unlink(folder / output)
    return good, result


with Folder() as folder:
    fine("make", "make", "sphere", "--size", "6", "-o", folder / "v.nrrd")
    OUT = ["-o", "out.png", "--size", "6"]
    PLANS = [
        (["render", "v.nrrd"], OUT, "out.png"),
        (["info", "v.nrrd"], [], "none"),
        (["convert", "v.nrrd", "out.nrrd"], [], "out.nrrd"),
        (["bench", "v.nrrd"], ["--size", "6", "--frames", "1", "--warmup", "0"], "none"),
        (["compare", "a.png", "a.png"], [], "none"),
    ]
    for line in run("make", "--list").text.splitlines():
        PLANS.append((["make", line.split()[0]], ["-o", "out.nrrd", "--size", "6"], "out.nrrd"))
    fine("picture", "render", "v.nrrd", "-o", "a.png", "--size", "6", cwd=folder.path)
    tested, rendered = set(), set()
    for command, words, output in PLANS:
        for name, (_, facts) in options_of(*command[:2] if command[0] == "make" else command[:1]).items():
            if (command[0] in ("bench", "make") or name == "help") and (command[0], name) in tested or command[0] == "bench" and name in rendered:
                continue # had it
            bad = []
            for value in values_of(name, facts):
                # What the test itself needs comes later and wins; --size and --output are tested by coming last.
                more = list(words)
                if name in ("size", "output", "frames", "warmup"):
                    flag = {"output": "-o"}.get(name, "--" + name)
                    if flag in more:
                        at = more.index(flag)
                        del more[at:at + 2]
                if command[0] == "make" and name == "size":
                    value = {"32768x1": "2", "1x32768": "3"}.get(value, value)
                good, result = hammer(command, more, name, value, output, folder)
                if not good:
                    bad.append(str(result))
            tested.add((command[0], name))
            if command[0] == "render":
                rendered.add(name)
            check(not bad, "%s --%s" % (command[0] if command[0] != "make" else " ".join(command), name), "\n".join(bad))
    check(len(rendered) >= 40, "the help names the options", sorted(rendered))

    # Switches of no sense together, and NaN where a list is read.
    for words in [["--isovalue", "1e308"], ["--isovalue", "-1e308,1e308"], ["--opacity", "0:0,nan:1"], ["--opacity", "0:2"], ["--opacity", "1e308:1,-1e308:0"],
                  ["--spacing", "1e-30,1,1e30"], ["--spacing", "1e30,1e30,1e30"], ["--spacing", "1e-30,1e-30,1e-30"], ["--step", "0.01", "--spacing", "1,1,1e9"],
                  ["--camera-position", "1e300,0,0"], ["--camera-position", "0,0,0", "--camera-focal-point", "0,0,0"], ["--camera-view-angle", "179.9"],
                  ["--camera-view-angle", "0.001"], ["--clip-box=-1e308,1e308,-1e308,1e308,-1e308,1e308"], ["--slice", "1e300,0,0,1e300,0,0"],
                  ["--clip-plane", "0,0,0,1e-300,0,0"], ["--clip-plane", "0,0,0,1e300,1e300,1e300"], ["--light", "1e300,1e300,1e300"],
                  ["--unit-distance", "1e-30"], ["--unit-distance", "1e30"], ["--zoom", "1000", "--elevation", "1e6"], ["--parallel", "--zoom", "0.001"],
                  ["--range=-1e308,1e308"], ["--range=1e308,-1e308"], ["--void=1e308"], ["--void", "0", "--mode", "minip"], ["--range", "0,1e-300"]]:
        for more in [], ["--technique", "reference"]:
            result = run("render", "v.nrrd", *OUT, *words, *more, cwd=folder.path, env=ENVIRONMENT)
            check(result.status in (0, 1, 2) and (result.status == 0 or result.one_error()), " ".join(words + more), result)
finish()
