# SPDX-License-Identifier: MIT
"""devices: what it tells of a GPU, and why there is none. Libraries are hidden by empty files of their names, which the loader finds first."""
import os

from harness import Folder, check, fails, fine, finish, run, skip, write


def hidden(folder, *names):
    """An environment in which these libraries do not load."""
    for name in names:
        write(folder / name, b"")
    return dict(os.environ, LD_LIBRARY_PATH=folder.path)


KEYS = {"index", "name", "vendor", "version", "path", "node", "software", "usable", "chosen", "note", "memory_bytes", "limits"}
LIMITS = {"texture_2d", "texture_3d", "array_layers", "storage_buffer_bytes", "compute_invocations"}

told = fine("devices --json", "devices", "--json").json()
text = fine("devices", "devices").text
devices = told["devices"]
check(all(set(d) == KEYS and set(d["limits"]) == LIMITS for d in devices), "each device has every key", told)
check([d["index"] for d in devices] == list(range(len(devices))), "they are numbered from 0", told)
check(bool(devices) != ("reason" in told), "a reason where there is none, and only there", told)
check(all(d["note"] and d["note"] in text for d in devices), "each says why it is or is not chosen", text)
usable = [d for d in devices if d["usable"]]
check(sum(d["chosen"] for d in devices) == (1 if usable else 0), "one of the usable is chosen", told)
fails("devices takes no operand", 2, "too many", "devices", "x")

if usable:
    chosen = next(d for d in devices if d["chosen"])
    check(not chosen["software"] or all(d["software"] for d in usable), "hardware before software", told)
    limits = chosen["limits"]  # the least that OpenGL 4.5 allows
    check(limits["texture_2d"] >= 16384 and limits["texture_3d"] >= 2048 and limits["array_layers"] >= 2048 and limits["storage_buffer_bytes"] >= 1 << 24 and
          limits["compute_invocations"] >= 1024, "limits are plausible", limits)
    if chosen["vendor"].startswith("Mesa"):
        old = run("devices", "--json", env=dict(os.environ, MESA_GL_VERSION_OVERRIDE="3.3")).json()["devices"][chosen["index"]]
        check(not old["usable"] and not old["chosen"] and "4.5" in old["note"] and "3.3" in old["note"], "a driver that is too old is told with its version", old)
    else:
        skip("a driver that is too old is told with its version", "not Mesa's")
else:
    skip("limits are plausible", "no usable device: %s" % told)

for names in [["libEGL.so.1"], ["libOpenGL.so.0", "libGL.so.1"], ["libEGL.so.1", "libOpenGL.so.0", "libGL.so.1"]]:
    with Folder() as folder:
        env = hidden(folder, *names)
        label = "without " + ", ".join(names) + ": "
        told = fine(label + "devices --json", "devices", "--json", env=env).json()
        check(told["devices"] == [] and "there is no GPU" in told["reason"] and names[0] in told["reason"], label + "the reason", told)
        result = fine(label + "devices", "devices", env=env)
        check(names[0] in result.text and not result.err, label + "the reason for people", result)
        fine(label + "make", "make", "sphere", "--size=12", "-o", folder / "v.nrrd", env=env)
        fine(label + "the CPU engine draws", "render", folder / "v.nrrd", "-o", folder / "a.png", "--size=16", env=env)
finish()
