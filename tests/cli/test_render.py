# SPDX-License-Identifier: MIT
"""render, compare, bench, techniques: the pictures arrive, flags mean what they say, scenes repeat a picture, nothing is left half done."""
import glob
import json
import os
import resource
import shutil
import signal
import struct
import subprocess
import time

from harness import DATA, TOOL, Folder, check, colours, fails, fine, finish, nrrd, png, read, run, skip, write

MODES = ["composite", "mip", "minip", "average", "xray", "isosurface", "slice"]


def compare(a, b, *more):
    result = run("compare", a, b, "--json", *more)
    return result, result.json() if result.out else {}


with Folder() as folder:
    volume = folder / "v.nrrd"
    fine("make", "make", "marschner-lobb", "--size", "24", "-o", volume)
    base = ["render", volume, "--size", "40x30"]

    # Every mode gives a picture; each of the two techniques, and they agree.
    for mode in MODES:
        for technique in ["raycast", "reference"]:
            path = folder / ("%s-%s.png" % (mode, technique))
            result = fine("%s by %s" % (mode, technique), *base, "-o", path, "--mode", mode, "--technique", technique)
            if result.status == 0:
                width, height, channels, _ = png(read(path))
                check((width, height, channels) == (40, 30, 3) and not result.out and not result.err, "its size, and silence", result)
                check(colours(path) > 3, "it is not blank", colours(path))
        result, told = compare(folder / (mode + "-raycast.png"), folder / (mode + "-reference.png"), "--psnr-min", "35")
        check(result.status == 0, mode + ": the techniques agree", result)

    # A technique of one mode, with options of its own.
    slices = [*base, "--technique", "slices2d"]
    fine("slices", *slices, "-o", folder / "slices.png", "--supersampling", "4", "--intermediate", "picture", "--rays", "2")
    result, told = compare(folder / "slices.png", folder / "composite-reference.png", "--psnr-min", "35")
    check(result.status == 0, "slices2d agrees with the reference", result)
    sheared = [*slices, "--device", "cpu"]
    result = fine("shear-warp", *sheared, "-o", folder / "sheared.png", "--depth", folder / "sheared.nrrd", "--supersampling", "4", "--intermediate", "picture", "--rays", "2", "--stats", "json")
    check(result.json()["technique"] == "slices2d" and result.json()["device"] == "cpu" and [s["name"] for s in result.json()["stages"]][-2:] == ["shear", "warp"], "by the CPU", result)
    check(png(read(folder / "sheared.png"))[:2] == (40, 30) and colours(folder / "sheared.png") > 30 and run("info", "--json", folder / "sheared.nrrd").json()["min"] > 0, "a picture and its depth")
    check(compare(folder / "sheared.png", folder / "composite-reference.png", "--psnr-min", "35")[0].status == 0, "shear-warp agrees with the reference")
    for name, words in {"one thread": ["--threads", "1"], "no skipping": ["--no-skip"]}.items():
        fine(name, *sheared, "-o", folder / "again.png", "--supersampling", "4", "--intermediate", "picture", "--rays", "2", *words)
        check(read(folder / "again.png") == read(folder / "sheared.png"), "shear-warp, %s: the same bytes" % name)
    for name, words in {"linear": ["--opacity-correction", "linear"], "rays of a voxel": ["--intermediate", "voxel"], "unshaded": ["--no-shade"], "supersampled": ["--supersampling", "3"]}.items():
        fine("shear-warp, plain", *sheared, "-o", folder / "plain.png", "--intermediate", "picture")
        fine("shear-warp, " + name, *sheared, "-o", folder / "again.png", "--intermediate", "picture", *words)
        check(read(folder / "again.png") != read(folder / "plain.png") and colours(folder / "again.png") > 30, name + ": another picture, not a blank one")
    for mode in MODES[1:]:
        fails("shear-warp in mode " + mode, 2, "composite alone on the CPU; use the technique raycast", *sheared, "-o", folder / "no.png", "--mode", mode)
    for classification in ["pre", "preintegrated"]:
        fails("shear-warp classifying " + classification, 2, "post) alone on the CPU; use the technique raycast", *sheared, "-o", folder / "no.png", "--classification", classification)
    for words in [["--lighting", "voxel"], ["--lighting", "global"], ["--texture-coordinates", "shared"]]:
        fails("shear-warp with " + " ".join(words), 2, "use --device gpu", *sheared, "-o", folder / "no.png", *words)
    fails("shear-warp with too many rays", 2, "--rays", *sheared, "-o", folder / "no.png", "--rays", "9")
    check(not os.path.exists(folder / "no.png"), "nothing is drawn of what is refused")
    result = run(*slices, "-o", folder / "no.png", "--supersampling", "11")
    check(result.status == 2 and "supersampling" in result.err, "an option of a technique beyond its limits", result)

    # Outputs.
    fine("png", *base, "-o", folder / "a.png")
    result = run(*base, "-o", "-")
    check(result.status == 0 and result.out == read(folder / "a.png"), "-o - writes the same bytes to standard output", len(result.out))
    result = run(*base, "-o", "-", "--stats", "json")
    check(result.out == read(folder / "a.png") and "stages" in json.loads(result.err), "--stats json leaves the picture on standard output alone", result.err)
    result = run(*base, "-o", folder / "b.png", "--stats", "json")
    told = result.json()
    check(list(told) == ["technique", "reason", "device", "device_note", "isa", "threads", "load_ms", "stages", "counters"] and told["stages"] and
          all(set(s) == {"name", "cpu_ms", "gpu_ms"} for s in told["stages"]) and told["counters"].get("samples taken", 0) > 0, "--stats json", result)
    check(told["technique"] == "raycast" and told["reason"] is None, "a technique that was named needs no reason", told)
    result = run(*base, "-o", folder / "c.png", "--stats", "json", "--technique", "auto", "--device", "cpu")
    told = result.json()
    check(told["technique"] == "raycast" and "on the CPU" in told["reason"] and read(folder / "c.png") == read(folder / "a.png"), "auto tells what it took and why", told)
    result = run(*base, "-o", folder / "b.png", "--stats")
    check(not result.out and "samples taken" in result.err and "load" in result.err, "--stats is text on standard error", result)
    result = run(*base, "--stats", "text", "-o", folder / "b.png")
    check(result.status == 0 and "samples taken" in result.err, "--stats text", result)
    fine("float picture", *base, "-o", folder / "a.nrrd", "--depth", folder / "d.nrrd")
    check(read(folder / "a.nrrd").startswith(b"NRRD") and b"float" in read(folder / "a.nrrd")[:400], "a float NRRD")
    depth = run("info", "--json", folder / "d.nrrd").json()
    check(depth["dims"][:2] == [40, 30] and depth["type"] == "f32" and depth["min"] > 0, "--depth holds distances", depth)
    result, told = compare(folder / "a.nrrd", folder / "a.png", "--max-error", "0.01")
    check(told.get("size") == [40, 30], "png and float pictures compare", result)
    fine("alpha", *base, "-o", folder / "c.png", "--alpha", "--zoom", "0.5")
    width, height, channels, rows = png(read(folder / "c.png"))
    check(channels == 4 and rows[0][3] == 0 and any(row[x * 4 + 3] > 0 for row in rows for x in range(width)), "--alpha keeps transparency")
    fine("background", *base, "-o", folder / "c.png", "--background", "#3366ff", "--zoom", "0.5")
    check(png(read(folder / "c.png"))[3][0][:3] == b"\x33\x66\xff", "--background is behind")
    fine("xray", *base, "-o", folder / "c.png", "--mode", "xray", "--zoom", "0.5")
    check(png(read(folder / "c.png"))[3][0][:3] == b"\xff\xff\xff", "an X-ray's background is white")
    fine("xray inverted", *base, "-o", folder / "c.png", "--mode", "xray", "--invert", "--zoom", "0.5")
    check(png(read(folder / "c.png"))[3][0][:3] == b"\0\0\0", "an inverted one's is black")

    # What must not, or must, change a byte.
    one = folder / "t.png"
    for name, words in {"threads": ["--threads", "1"], "threads 2": ["--threads", "2"], "no skipping": ["--no-skip"], "device": ["--device", "cpu"],
                        "the default size of a step": ["--step", "0.5"], "the default technique": ["--technique=raycast"]}.items():
        fine(name, *base, "-o", one, *words)
        check(read(one) == read(folder / "a.png"), name + ": the same bytes")
    for name, words in {"colormap": ["--colormap", "inferno"], "opacity": ["--opacity", "0:0,1:0.5"], "range": ["--range", "0.2,0.6"],
                        "unit-distance": ["--unit-distance", "0.5"], "shade": ["--no-shade"], "azimuth": ["--azimuth", "20"],
                        "elevation": ["--elevation", "20"], "roll": ["--roll", "20"], "zoom": ["--zoom", "1.3"], "parallel": ["--parallel"],
                        "view angle": ["--camera-view-angle", "60"], "position": ["--camera-position", "3,-4,5"], "isovalue": ["--isovalue", "0.5"],
                        "isovalues": ["--isovalue", "0.3,0.6", "--iso-opacity", "0.5", "--iso-color", "#ff0000", "--iso-color", "0,1,0"],
                        "slice": ["--slice", "0,0,0,1,1,0"], "clip plane": ["--clip-plane", "0,0,0,1,0,0"], "clip box": ["--clip-box=-9,0,-9,0,-9,9"],
                        "light": ["--light", "1,0,0"], "light colour": ["--light-color", "#ff8000"], "linear light": ["--linear-light"], "spacing": ["--spacing", "1,1,2"],
                        "step": ["--step", "3"], "jitter": ["--jitter"], "pre": ["--classification", "pre"]}.items():
        fine(name, *base, "-o", one, *words)
        check(read(one) != read(folder / "a.png") and colours(one) > 1, name + " makes another picture, not a blank one", colours(one))
    result = fine("refined", *base, "-o", folder / "r.nrrd", "--step", "2", "--refine", "6", "--stats", "json")
    check(result.json()["counters"].get("frames averaged") == 6, "--refine draws until it is done", result)
    result = fine("refined slice", *base, "-o", one, "--mode", "slice", "--refine", "200", "--stats", "json", "--device", "cpu")
    check(result.json()["counters"].get("frames averaged") == 200 and result.json()["stages"], "where jitter moves nothing that is soon", result)
    fine("fine", *base, "-o", folder / "f.nrrd", "--step", "0.0625")
    fine("half", *base, "-o", folder / "h.nrrd", "--step", "0.5")
    refined, half = [compare(folder / name, folder / "f.nrrd")[1].get("psnr", 0) for name in ["r.nrrd", "h.nrrd"]]
    check(refined > half + 6, "a refined picture is nearer to the truth", (refined, half))
    fine("refined turntable", *base, "-o", folder / "turn.nrrd", "--turntable", "2", "--step", "2", "--refine", "6")
    check(read(folder / "turn_0000.nrrd") == read(folder / "r.nrrd"), "each picture of a turntable is refined")
    fails("too many frames", 2, "--refine", *base, "-o", one, "--refine", "257")
    for top in ["0,0,9", "0,9,0", "0,0,-9"]:
        fine("straight down from " + top, *base, "-o", one, "--camera-position", top)
        check(colours(one) > 3, "it shows something")
    fine("over the pole", *base, "-o", one, "--elevation", "70")
    check(colours(one) > 3, "it shows something")

    # The GPU engine, where there is a device (or software in its place): nearly the same picture.
    devices = run("devices", "--json").json()["devices"]
    if any(d["usable"] for d in devices):
        fine("on the CPU", *base, "-o", folder / "cpu.png", "--device", "cpu")
        fine("on a GPU", *base, "-o", folder / "gpu.png", "--device", "gpu")
        fine("alike", "compare", folder / "cpu.png", folder / "gpu.png", "--psnr-min", "45")
        fine("on a GPU by number", *base, "-o", folder / "gpu.png", "--device", "gpu:%d" % [d["index"] for d in devices if d["usable"]][0])
        result = run(*base, "-o", folder / "auto.png", "--isovalue", "0.5", "--size", "16", "--turntable", "7", "--technique", "auto", "--device", "gpu", "--stats")
        check(result.status == 0 and "ms by raycast" in result.err and "ms by peel" in result.err, "auto has measured both after six frames", result)
        # Kept programs, then damaged ones: cut off, garbled, empty, not writable.
        cache = str(folder / "cache")
        env = dict(os.environ, XDG_CACHE_HOME=cache)
        fine("programs are kept", *base, "-o", folder / "gpu.png", "--device", "gpu", env=env)
        whole = read(folder / "gpu.png")
        kept = sorted(glob.glob(os.path.join(cache, "pellucid", "*.bin")))
        for name, damage in {"cut off": lambda b: b[:len(b) // 2], "garbled": lambda b: b[:60] + bytes(255 - x for x in b[60:]), "empty": lambda b: b""}.items():
            for path in kept:
                bytes_of = read(path)
                with open(path, "wb") as f:
                    f.write(damage(bytes_of))
            fine("kept programs, " + name, *base, "-o", folder / "gpu.png", "--device", "gpu", env=env)
            check(read(folder / "gpu.png") == whole, "the same picture with programs " + name)
        fine("no place for programs", *base, "-o", folder / "gpu.png", "--device", "gpu", env=dict(os.environ, XDG_CACHE_HOME="/dev/null"))
        check(read(folder / "gpu.png") == whole, "the same picture with no place for programs")
        fails("a GPU that is not there", 2, "--device", *base, "-o", folder / "none.png", "--device", "gpu:99")
    else:
        fails("no GPU", 1, "there is no GPU", *base, "-o", folder / "none.png", "--device", "gpu")

    # A scene repeats its picture, byte by byte, and flags override it.
    fine("a colour map file", *base, "-o", one, "--colormap", "viridis")
    SCENES = {"plain": [], "curve": ["--opacity", "0:0,0.4:0.1,1:0.9", "--colormap", "plasma", "--unit-distance", "0.1"],
              "iso": ["--isovalue", "0.3,0.6", "--iso-opacity", "0.4,1"], "iso one": ["--mode", "isosurface"], "slice": ["--slice", "0,0,0,1,2,3"],
              "slices": ["--slice", "0,0,0,1,0,0", "--slice", "0,0,0,0,1,0", "--slice", "0,0,0.2,1,1,1"],
              "slices2d": ["--technique", "slices2d", "--supersampling", "3", "--rays", "1.5"],
              "slice default": ["--mode", "slice"], "mip": ["--mode", "mip"], "xray": ["--mode", "xray", "--invert"],
              "moves": ["--azimuth", "33", "--elevation", "21", "--roll", "7", "--zoom", "1.7"], "parallel": ["--parallel", "--zoom", "1.1"],
              "clip": ["--clip-plane", "0,0,0,1,0,0", "--clip-plane", "0,0,0,0,1,0", "--clip-box=-9,9,-9,9,-9,0.5"],
              "lights": ["--light", "1,0,0", "--light", "0,-1,1", "--light-color", "1,0.2,0", "--light-color", "#4080ff", "--background", "0.2,0.3,0.4"], "labels": ["--labels"], "spacing": ["--spacing", "1,2,3"], "void": ["--void", "0"], "no labels": ["--no-labels"],
              "optics": ["--step", "0.8", "--jitter", "--termination", "0.9", "--no-shade", "--linear-light", "--classification", "preintegrated"]}
    for name, words in SCENES.items():
        fine("save " + name, *base, "-o", one, "--save-scene", folder / "s.json", *words)
        fine("load " + name, "render", "--scene", folder / "s.json", "--size", "40x30", "-o", folder / "u.png")
        check(os.path.exists(folder / "u.png") and read(one) == read(folder / "u.png"), "scene %s gives the same bytes" % name)
        if os.path.exists(folder / "u.png"):
            os.unlink(folder / "u.png")
    # A scene names its technique with all options; flags are over it, another technique has nothing of it.
    drawn = lambda name, *words: fine(name, "render", "--scene", folder / "s.json", "--size", "40x30", "-o", folder / "u.png", "--device", "cpu", *words) and read(folder / "u.png")
    sliced = [*base, "--technique", "slices2d", "--device", "cpu"]
    fine("save a technique", *sliced, "-o", one, "--save-scene", folder / "s.json", "--supersampling", "3", "--intermediate", "picture", "--rays", "2")
    told = json.loads(read(folder / "s.json"))["technique"]
    names = {row["name"] for t in run("techniques", "--json").json() if t["name"] == "slices2d" for row in t["options"]}
    check(told["name"] == "slices2d" and told["options"]["supersampling"] == 3 and told["options"]["intermediate"] == "picture" and set(told["options"]) == names, "what it says of it", told)
    check(drawn("load a technique") == read(one), "the same picture by the scene's technique and options")
    check(drawn("the technique again", "--technique", "slices2d") == read(one), "naming it again changes nothing")
    fine("other options", *sliced, "-o", one, "--supersampling", "1", "--intermediate", "picture", "--rays", "2")
    check(drawn("an option over it", "--supersampling", "1") == read(one), "a flag is over the scene's option, which leaves the others")
    fine("the ray caster", *base, "-o", one, "--device", "cpu")
    check(drawn("another technique", "--technique", "raycast", "--save-scene", folder / "cast.json") == read(one), "another technique is that one's picture")
    check(json.loads(read(folder / "cast.json"))["technique"] == {"name": "raycast", "options": {}}, "and scene", read(folder / "cast.json"))
    for key, word, wrong in [("misspelt", "technique.options.suprsampling", {"name": "slices2d", "options": {"suprsampling": 3}}), ("unknown", "technique.name", {"name": "slices4d"}),
                             ("beyond its limits", "technique.options.supersampling", {"name": "slices2d", "options": {"supersampling": 11}}),
                             ("of another technique", "technique.options.cull", {"name": "slices2d", "options": {"cull": "band"}}), ("nameless", "technique: ", {"options": {}})]:
        write(folder / "wrong.json", json.dumps(dict(json.loads(read(folder / "s.json")), technique=wrong)))
        result = fails("a technique's key " + key, 1, "wrong.json: ", "render", "--scene", folder / "wrong.json", "-o", folder / "no.png")
        check(word in result.err, "it names the key", result)

    # Several planes: three are more than any one of them; a flag replaces all of a scene's.
    planes = ["--slice=0,0,0,1,0,0", "--slice=0,0,0,0,1,0", "--slice=0,0,0,0,0,1"]
    view = ["--camera-position", "3,-5,4", "--camera-focal-point", "0,0,0", "--alpha"]
    covered = {}
    for name, words in {"all": planes, "x": planes[:1], "y": planes[1:2], "z": planes[2:]}.items():
        fine("planes " + name, *base, "-o", one, *words, *view, "--save-scene", folder / ("planes-%s.json" % name))
        covered[name] = {(x, y) for y, row in enumerate(png(read(one))[3]) for x in range(40) if row[4 * x + 3]}
    check(covered["all"] == covered["x"] | covered["y"] | covered["z"] and len(covered["all"]) > max(len(covered[p]) for p in "xyz"), "three planes cover what each does",
          {name: len(pixels) for name, pixels in covered.items()})
    fine("one for three", "render", "--scene", folder / "planes-all.json", "--size", "40x30", "-o", folder / "u.png", "--alpha", planes[2])
    check(read(folder / "u.png") == read(one), "--slice replaces a scene's planes")
    fails("nine planes", 2, "--slice", *base, "-o", folder / "no.png", *(3 * planes))
    fine("a scene alone", "render", volume, "--save-scene", folder / "alone.json", "--mode", "mip")
    check(json.loads(read(folder / "alone.json")), "it is JSON")
    fine("override", "render", "--scene", folder / "alone.json", "--mode", "composite", "--size", "40x30", "-o", one)
    # From elsewhere: a scene's path is relative to the scene.
    os.mkdir(folder / "sub")
    fine("relative", "render", "v.nrrd", "--save-scene", "sub/s.json", "--mode", "mip", "-o", "m.png", "--size", "40x30", cwd=folder.path)
    fine("from elsewhere", "render", "--scene", folder / "sub/s.json", "-o", one, "--size", "40x30", cwd="/")
    check(read(one) == read(folder / "m.png"), "a scene finds its volume from anywhere")
    fails("a scene that is none", 1, "v.nrrd", "render", "--scene", volume, "-o", folder / "no.png")
    fails("a scene that is not there", 1, "absent.json", "render", "--scene", folder / "absent.json", "-o", folder / "no.png")
    write(folder / "unknown.json", json.dumps(dict(json.loads(read(folder / "alone.json")), quux=1)))
    fails("a scene with an unknown key", 1, "quux", "render", "--scene", folder / "unknown.json", "-o", folder / "no.png")
    check(not os.path.exists(folder / "no.png"), "no picture of a bad scene")

    # Turntable.
    fine("turntable", *base, "-o", folder / "turn.png", "--turntable", "4", "--depth", folder / "turn.nrrd")
    names = [n for n in folder.names() if n.startswith("turn")]
    check(names == sorted("turn_%04d.%s" % (i, e) for i in range(4) for e in ("png", "nrrd")), "turntable's names", names)
    check(read(folder / "turn_0000.png") == read(folder / "a.png"), "its first picture is the plain one")
    fine("a quarter", *base, "-o", one, "--azimuth", "90")
    check(read(folder / "turn_0001.png") == read(one), "its second of four is a quarter further")

    # Vectors are drawn by their magnitude, with a note.
    field = nrrd(folder / "w.nrrd", [3, 8, 8, 8], "f", [float(i % 17) for i in range(3 * 512)])
    result = fine("a field", "render", field, "-o", one, "--size", "20")
    check("magnitude" in result.err and result.err.startswith("pellucid: note: "), "a note tells of the magnitude", result)
    check(not run("render", field, "-o", one, "--size", "20", "--quiet").err, "--quiet silences it")
    result = fine("an isovalue beyond the data", *base, "-o", one, "--isovalue", "1e6")
    check("nothing to be seen" in result.err and colours(one) == 1, "a note tells of an empty picture", result)
    fails("no such colour map", 2, "viridis", *base, "-o", folder / "no.png", "--colormap", "viridi")
    fails("an opacity of 4", 2, "--opacity", *base, "-o", folder / "no.png", "--opacity", "1:4")
    fails("a colour map file that is not there", 1, "nofile.json", *base, "-o", folder / "no.png", "--colormap", "nofile.json")
    # Nothing to see, and strange values, are no reason to fall.
    for name, values in {"constant": [5.0] * 64, "NaN": [float("nan")] * 64, "infinite": [float("inf")] * 64, "mixed": [float("nan"), float("inf"), 1, -1e38] * 16}.items():
        strange = nrrd(folder / "x.nrrd", [4, 4, 4], "f", values)
        for mode in MODES:
            result = run("render", strange, "-o", one, "--size", "8", "--mode", mode)
            check(result.status in (0, 1, 2) and (result.status == 0 or result.one_error()), "%s volume, %s" % (name, mode), result)
    for sizes in [1, 1, 1], [5, 1, 1], [1, 5, 5], [2, 2, 2]:
        thin = nrrd(folder / "x.nrrd", sizes, "B", list(range(sizes[0] * sizes[1] * sizes[2])))
        fine("a volume of %s" % sizes, "render", thin, "-o", one, "--size", "8")

    # Compare.
    fine("another", *base, "-o", folder / "b.png", "--azimuth", "40")
    result, told = compare(folder / "a.png", folder / "a.png", "--psnr-min", "100", "--max-error", "0")
    check(result.status == 0 and told == {"psnr": 999, "ssim": 1, "max_error": 0, "differing_pixels": 0, "identical": True, "alike": True, "same_size": True, "size": [40, 30]},
          "equal pictures", told)
    result, told = compare(folder / "a.png", folder / "b.png")
    check(result.status == 0 and not told["identical"] and 0 < told["max_error"] <= 1 and told["psnr"] < 99 and told["ssim"] < 1 and
          isinstance(told["differing_pixels"], int), "without limits the status is 0", told)
    check(run("compare", folder / "a.png", folder / "b.png", "--max-error", "0.001").status == 1, "beyond --max-error: 1")
    check(run("compare", folder / "a.png", folder / "b.png", "--psnr-min", "90").status == 1, "below --psnr-min: 1")
    text = run("compare", folder / "a.png", folder / "a.png")
    check(text.status == 0 and "identical" in text.text, "compare for people", text)
    fine("small", "render", volume, "-o", folder / "s.png", "--size", "20")
    fails("pictures of two sizes are unlike", 1, "size", "compare", folder / "a.png", folder / "s.png")
    fails("no picture", 1, "v.nrrd", "compare", folder / "a.png", volume)
    write(folder / "cut.png", read(folder / "a.png")[:-40])
    fails("a truncated picture", 1, "cut.png", "compare", folder / "a.png", folder / "cut.png")

    # Bench and techniques.
    for words in [], ["--isovalue", "0.5"]:
        result = fine("bench", "bench", volume, "--size", "24", "--frames", "3", "--warmup", "1", "--json", *words)
        told = result.json()
        check(list(told) == ["frame_ms", "first_frame_ms", "transfer_change_ms", "isovalue_change_ms", "samples_taken", "samples_skipped",
                             "cast_ms", "samples_per_second", "texture_samples_per_second", "upload_ms", "upload_mb_per_second", "device_bytes",
                             "peak_memory_mb", "volume_mb", "load_ms", "threads", "device", "isa", "technique", "reason", "size", "last_frame"], "bench's keys", list(told))
        check(set(told["frame_ms"]) == {"median", "min", "max", "all"} and len(told["frame_ms"]["all"]) == 3 and told["samples_taken"] > 0 and
              told["size"] == [24, 24] and (told["isovalue_change_ms"] is None) == (not words) and (told["transfer_change_ms"] is None) == bool(words) and
              told["frame_ms"]["min"] <= told["frame_ms"]["median"] <= told["frame_ms"]["max"], "bench's values", told)
        check(told["samples_per_second"] > 0 and told["cast_ms"]["median"] > 0, "bench's rates", told)
        if any(d["usable"] for d in devices):
            told = fine("bench on a GPU", "bench", volume, "--size", "24", "--frames", "1", "--device", "gpu", "--json", *words).json()
            check(all(told[key] > 0 for key in ["samples_per_second", "texture_samples_per_second", "upload_ms", "upload_mb_per_second", "device_bytes"]),
                  "what a GPU adds", told)
    if any(d["usable"] for d in devices):
        slices = ["render", volume, "--size", "32", "--step", "0.5", "--device", "gpu", "--technique", "slices3d"]
        fine("slices on a GPU", *slices, "-o", folder / "slices.png", "--cull", "ess+ert", "--cube-t", "8", "--opaque", "1")
        fine("the ray caster for comparison", *slices[:-2], "-o", folder / "cast.png")
        result, told = compare(folder / "slices.png", folder / "cast.png", "--psnr-min", "35")
        check(result.status == 0, "slices3d agrees with raycast", result)
        counters = fine("the cost model", *slices, "-o", folder / "cost.png", "--cost", "--stats=json").json()["counters"]
        check(counters["F"] >= counters["F_c'"] > 0 and counters["T_c, ps"] > 0, "counters of the cost model", counters)
        result = run(*slices, "-o", folder / "no.png", "--mode", "mip")
        check(result.status == 2 and "raycast" in result.err, "slices3d refuses other modes, and says what to use", result)
        peel = ["render", volume, "--size", "32", "--isovalue", "0.5", "--device", "gpu", "--technique", "peel"]
        fine("the ray caster's surface", *peel[:-2], "-o", folder / "cast.png", "--roots", "steps")
        fine("peeling", *peel, "-o", folder / "peel.png", "--roots", "steps", "--granularity", "3", "--cover", "disc", "--mask-path", "compute", "--no-interior")
        check(read(folder / "peel.png") == read(folder / "cast.png"), "peel by the ray caster's steps gives its bytes")
        told = fine("what peeling counts", *peel, "-o", folder / "peel.png", "--stats=json").json()
        check(told["counters"]["active cells"] > 0 and told["counters"]["segments"] >= told["counters"]["rays with segments"] > 0 and
              {"active cells", "masks", "cast rays"} <= {s["name"] for s in told["stages"]}, "its counters and stages", told)
        for words, word in [(["--mode", "composite"], "raycast"), (["--mode", "mip"], "raycast"), (["--granularity", "9"], "granularity"), (["--granularity", "0"], "granularity"),
                            (["--cover", "square"], "cover"), (["--mask-path", "cpu"], "mask-path"), (["--roots", "linear"], "roots"), (["--segments", "tree", "--no-interior"], "layer")]:
            result = run(*[w for w in peel if words[0] != "--mode" or w not in ("--isovalue", "0.5")], "-o", folder / "no.png", *words)
            check(result.status == 2 and word in result.err, "peel refuses " + " ".join(words), result)
        result = run(*peel, "-o", folder / "no.png", "--device", "cpu")
        check(result.status != 0 and "GPU" in result.err, "peel needs a GPU, and says so", result)
    fine("bench for people", "bench", volume, "--size", "24", "--frames", "1")
    told = run("techniques", "--json").json()
    check({t["name"] for t in told} >= {"raycast", "reference"} and all(set(t) == {"name", "summary", "citation", "engines", "options"} for t in told) and
          all(t["engines"] and ("cpu" in t["engines"] or t["name"] in ["slices3d", "mesh", "peel"]) for t in told), "techniques --json", told)
    check("raycast" in run("techniques").text, "techniques for people")

# Nothing is left where it fails: no room, no permission, Ctrl-C.
with Folder() as folder:
    volume = folder / "v.nrrd"
    fine("make", "make", "hydrogen", "--size", "32", "-o", volume)

    def small_files():
        resource.setrlimit(resource.RLIMIT_FSIZE, (3000, 3000))
    fails("no room for the picture", 1, "p.png", "render", volume, "-o", folder / "p.png", "--size", "200", "--compression", "0", preexec_fn=small_files)
    fails("no room for the depth", 1, "d.nrrd", "render", volume, "-o", folder / "p.png", "--depth", folder / "d.nrrd", "--size", "60",
          preexec_fn=small_files)
    # Depth is written first; a picture of another run outlives its failure, and a new one's failure takes a new depth with it, not an older one.
    older = write(folder / "older.png", b"a picture of yesterday")
    fails("no room for the depth beside an older picture", 1, "d.nrrd", "render", volume, "-o", older, "--depth", folder / "d.nrrd", "--size", "60",
          preexec_fn=small_files)
    check(read(older) == b"a picture of yesterday" and not os.path.exists(folder / "d.nrrd"), "the older picture is left alone")
    os.unlink(older)
    os.mkdir(older)
    fails("no picture, so no depth", 1, "older.png", "render", volume, "-o", older, "--depth", folder / "d.nrrd", "--size", "8")
    check(not os.path.exists(folder / "d.nrrd"), "no depth without its picture")
    fine("a depth alone", "render", volume, "--depth", folder / "d.nrrd", "--size", "8")
    fails("no picture beside an older depth", 1, "older.png", "render", volume, "-o", older, "--depth", folder / "d.nrrd", "--size", "8")
    check(os.path.exists(folder / "d.nrrd"), "the older depth stays")
    os.unlink(folder / "d.nrrd")
    os.rmdir(older)
    fails("no folder", 1, "nowhere", "render", volume, "-o", folder / "nowhere/p.png")
    os.mkdir(folder / "taken.png")
    fails("a folder in the way", 1, "taken.png", "render", volume, "-o", folder / "taken.png", "--size", "8")
    os.rmdir(folder / "taken.png")
    with open("/dev/full", "wb") as full:
        result = run("render", volume, "-o", "-", "--size", "8", stdout=full)
    check(result.status == 1 and result.one_error(), "a full disk behind -o -", result)
    closed = subprocess.run(["bash", "-c", '"$0" render "$1" -o - --size 8 >&-', TOOL, volume], capture_output=True)
    check(closed.returncode == 1 and closed.stderr.startswith(b"pellucid: "), "a closed standard output", closed)
    beside = subprocess.run(["bash", "-c", 'cd "$2" && "$0" render "$1" -o q.png --size 8 --stats json >&-', TOOL, volume, folder.path], capture_output=True)
    check(beside.returncode == 1 and (not os.path.exists(folder / "q.png") or png(read(folder / "q.png"))[:2] == (8, 8)),
          "closed standard streams do not leak into files", beside)
    if os.path.exists(folder / "q.png"):
        os.unlink(folder / "q.png")
    for number in [signal.SIGINT, signal.SIGTERM]:
        slow = subprocess.Popen([TOOL, "render", volume, "-o", folder / "big.png", "--depth", folder / "big.nrrd", "--save-scene", folder / "big.json",
                                 "--technique", "reference", "--size", "3000", "--step", "0.05"], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        time.sleep(1)
        running = slow.poll() is None
        slow.send_signal(number)
        _, err = slow.communicate(timeout=200)
        check(running and slow.returncode == 130 and err.startswith(b"pellucid: "), "signal %d: status 130" % number, (slow.returncode, err))
    check(folder.names() == ["v.nrrd"], "nothing is left", folder.names())

# The real data: each scalar file gives a default picture that is not blank.
for name in ["aneurism.nrrd", "bonsai.nii.gz", "engine.nhdr", "neghip.nrrd", "tooth.nhdr", "cthead", "template_T2.nrrd", "inia19-t1-brain.nii.gz",
             "HeadMRVolume.mhd", "frogtissue.mhd", "ironProt.vtk", "hydrogen.vti", "isabel_speed.vti", "pet_dicom", "wind.nrrd", "carotid_velocity.nrrd"]:
    path = os.path.join(DATA, name)
    if not os.path.exists(path):
        skip("default picture of " + name, "no data folder")
        continue
    with Folder() as folder:
        if fine("default picture of " + name, "render", path, "-o", folder / "p.png", "--size", "48").status == 0:
            check(colours(folder / "p.png") > 30, name + " shows something", colours(folder / "p.png"))

# A ray of this picture passes over empty cells and comes out of the volume by an edge of the last, where it must end.
engine = os.path.join(DATA, "engine.nhdr")
if os.path.exists(engine):
    with Folder() as folder:
        fine("rays that end at an edge", "render", engine, "-o", folder / "a.png", "--isovalue", "80.5", "--size", "256")
        fine("the same without skipping", "render", engine, "-o", folder / "b.png", "--isovalue", "80.5", "--size", "256", "--no-skip")
        check(read(folder / "a.png") == read(folder / "b.png"), "skipping changes no byte of rays that end at an edge")
else:
    skip("rays that end at an edge", "no data folder")
finish()
