# SPDX-License-Identifier: MIT
"""info, make, convert: contracts of their output, round trips, bad files."""
import math
import os
import resource
import struct

from harness import DATA, Folder, check, fails, fine, finish, nrrd, read, run, skip, write

KEYS = ["file", "format", "dims", "type", "components", "spacing", "origin", "direction", "space", "units", "min", "max", "mean", "nonzero", "voids",
        "infinite", "labels", "name", "arrays", "notes"]


def info(path, *more):
    result = run("info", "--json", path, *more)
    if not check(result.status == 0, "info --json " + os.path.basename(str(path)), result):
        return {}
    try:
        return result.json()
    except ValueError as problem:
        check(False, "info --json is JSON", problem)
        return {}


# Every number of the contract, on a file whose numbers are known.
with Folder() as folder:
    values = [0.1, -2.5, float("nan"), float("inf"), 0.0, 1e-40, 7.25, 3.0]
    path = nrrd(folder / "v.nrrd", [2, 2, 2], "f", values,
                "space: left-posterior-superior\nspace directions: (0.1,0,0) (0,0.7,0) (0,0,-1.3)\nspace origin: (0.3,-1e-7,12345.678901234567)")
    told = info(path)
    check(list(told) == KEYS, "the keys of the contract, in their order", list(told))
    check(told["file"] == path and told["format"] == "nrrd" and told["dims"] == [2, 2, 2] and told["type"] == "f32" and told["components"] == 1, "what it is", told)
    check(all(math.isclose(a, b, rel_tol=1e-15) for a, b in zip(told["spacing"], [0.1, 0.7, 1.3])), "spacing is lossless", told["spacing"])
    check(told["origin"] == [0.3, -1e-7, 12345.678901234567] and told["space"] == "LPS", "origin is lossless, space is told", told)
    check(all(math.isclose(a, b, abs_tol=1e-15) for row, want in zip(told["direction"], [[1, 0, 0], [0, 1, 0], [0, 0, -1]]) for a, b in zip(row, want)),
          "direction has a row for each index axis", told["direction"])
    single = struct.unpack("f", struct.pack("f", 1e-40))[0]
    tenth = struct.unpack("f", struct.pack("f", 0.1))[0]
    check(told["min"] == -2.5 and told["max"] == 7.25 and told["nonzero"] == 5 and told["voids"] == 1 and told["infinite"] == 1, "counts", told)
    check(math.isclose(told["mean"], (tenth - 2.5 + single + 7.25 + 3) / 6, rel_tol=1e-12), "mean", told["mean"])
    check(told["labels"] is False and all(set(a) == {"name", "type", "components"} for a in told["arrays"]), "arrays", told["arrays"])
    check(info(path, "--void", "0")["voids"] == 2, "--void counts")
    told = info(nrrd(folder / "n.nrrd", [1, 2, 2], "d", [float("nan")] * 4))
    check(told["min"] is None and told["max"] is None and told["mean"] is None and told["voids"] == 4, "nothing finite: null", told)
    told = info(nrrd(folder / "w.nrrd", [3, 2, 2, 2], "f", [3, 4, 12] + [0] * 21))
    check(told["components"] == 3 and told["dims"] == [2, 2, 2] and told["max"] == 13 and told["nonzero"] == 1, "a vector's magnitude", told)
    told = info(nrrd(folder / "q.nrrd", [2, 2, 2], "B", range(8), 'content: a "quoted\\\\ name'))
    check(isinstance(told.get("name"), str), "a name with quotes is good JSON", told)
    told = info(write(folder / "raw.bin", bytes(range(24))), "--raw", "2x3x4:u8")
    check(told["dims"] == [2, 3, 4] and told["format"] == "raw" and told["max"] == 23, "--raw", told)
    text = run("info", folder / "v.nrrd", "--histogram")
    check(text.status == 0 and "2 x 2 x 2 f32" in text.text and "#" in text.text, "info for people", text)

# Each computed data set, small.
with Folder() as folder:
    names = [line.split()[0] for line in run("make", "--list").text.splitlines()]
    check(len(names) >= 6, "make --list", names)
    for name in names:
        page = run("make", name, "--help")
        check(page.status == 0 and "--size" in page.text, "make %s --help" % name, page)
        if fine("make " + name, "make", name, "--size", "10", "-o", folder / (name + ".nrrd")).status == 0:
            told = info(folder / (name + ".nrrd"))
            check(told["dims"] == [10, 10, 10] and told["voids"] == 0 and told["infinite"] == 0 and told["max"] >= told["min"], name + " is there", told)
    fine("again", "make", "hydrogen", "--size", "10", "-o", folder / "again.nrrd")
    check(read(folder / "again.nrrd") == read(folder / "hydrogen.nrrd"), "make gives the same bytes each time")

# Round trips through every format that is written, of every number type.
with Folder() as folder:
    for code, kind in {"B": "u8", "b": "i8", "H": "u16", "h": "i16", "I": "u32", "i": "i32", "f": "f32", "d": "f64"}.items():
        low = 0 if code.isupper() else -50
        values = [low + i * 3 for i in range(24)]
        first = nrrd(folder / "a.nrrd", [2, 3, 4], code, values, "space: right-anterior-superior\nspace directions: (0.5,0,0) (0,0,2) (0,-3,0)\nspace origin: (1,2,3)")
        before = info(first)
        check(before.get("type") == kind, "type " + kind, before)
        for ending in [".vti", ".mha", ".nhdr", ".mhd", ".nrrd"]:
            for more in [], ["--compress"]:
                second = folder / ("b%s%d%s" % (ending[1:], len(more), ending)) # names of their own: a header does not replace another's data
                fine("%s to %s %s" % (kind, ending, "".join(more)), "convert", first, second, *more)
                fine("and back", "convert", second, folder / "c.nrrd")
                after = info(folder / "c.nrrd")
                same = ["dims", "type", "components", "min", "max", "mean", "nonzero", "spacing"]
                check([after.get(k) for k in same] == [before[k] for k in same], "%s through %s %s" % (kind, ending, "".join(more)), (before, after))
                check(read(folder / "c.nrrd")[-len(values) * struct.calcsize("<" + code):] == read(first)[-len(values) * struct.calcsize("<" + code):],
                      "the samples are the same bytes")

# Conversion.
with Folder() as folder:
    path = nrrd(folder / "f.nrrd", [2, 2, 1], "f", [0.0, 0.5, 1.0, 300.0], "space: left-posterior-superior\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (1,2,3)")
    result = fine("to u8", "convert", path, folder / "u.nrrd", "--type", "u8")
    check(read(folder / "u.nrrd")[-4:] == bytes([0, 0, 1, 255]) and "clamped" in result.err and "rounded" in result.err, "values that do not fit are told", result)
    result = fine("to u8 with a range", "convert", path, folder / "u.nrrd", "--type", "u8", "--range", "0,1")
    check(read(folder / "u.nrrd")[-4:] == bytes([0, 128, 255, 255]) and not result.err, "--range stretches", (read(folder / "u.nrrd")[-4:], result.err))
    fine("to RAS", "convert", path, folder / "r.nrrd", "--space", "RAS")
    told = info(folder / "r.nrrd")
    check(told["space"] == "RAS" and told["origin"] == [-1, -2, 3] and told["direction"][0][0] == -1, "--space turns the placement", told)
    fine("spacing", "convert", path, folder / "s.nrrd", "--spacing", "2,3,4")
    check(info(folder / "s.nrrd")["spacing"] == [2, 3, 4], "--spacing")
    path = nrrd(folder / "w.nrrd", [3, 2, 1, 1], "f", [3, 4, 0, 0, 0, 2])
    fine("magnitude", "convert", path, folder / "m.nrrd", "--magnitude")
    check(read(folder / "m.nrrd")[-8:] == struct.pack("<2f", 5, 2), "--magnitude")
    fails("--range without --type", 2, "--type", "convert", path, folder / "x.nrrd", "--range", "0,1")
    fails("an ending that is not known", 2, "x.abc", "convert", path, folder / "x.abc")
    fails("a folder that is not there", 1, "nowhere", "convert", path, folder / "nowhere/x.nrrd")
    check(not os.path.exists(folder / "x.nrrd") and not os.path.exists(folder / "x.abc"), "no file after a failure")

# Bad files: one line, status 1, no output.
with Folder() as folder:
    good = read(nrrd(folder / "good.nrrd", [4, 4, 4], "H", range(64)))
    BAD = {
        "truncated.nrrd": good[:-10],
        "headeronly.nrrd": good[:30],
        "unended.nrrd": good.replace(b"\n\n", b"\nspace: left-posterior-superior\n"),
        "empty.nrrd": b"",
        "zero.nrrd": good.replace(b"sizes: 4 4 4", b"sizes: 4 0 4"),
        "negative.nrrd": good.replace(b"sizes: 4 4 4", b"sizes: 4 -4 4"),
        "overflow.nrrd": good.replace(b"sizes: 4 4 4", b"sizes: 4294967296 4294967296 4"),
        "huge.nrrd": good.replace(b"sizes: 4 4 4", b"sizes: 100000 100000 100"),
        "type.nrrd": good.replace(b"uint16", b"quux"),
        "cyclic.nhdr": good.split(b"\n\n")[0] + b"\ndata file: cyclic.nhdr\n\n",
        "detached.nhdr": good.split(b"\n\n")[0] + b"\ndata file: not-there.raw\n\n",
        "noise.bin": bytes((i * 7919 + 13) % 251 for i in range(5000)),
        "text.txt": b"hello\n",
        "huge.mhd": b"ObjectType = Image\nNDims = 3\nDimSize = 4000000 4000000 4000000\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n",
        "self.mhd": b"ObjectType = Image\nNDims = 3\nDimSize = 4 4 4\nElementType = MET_UCHAR\nElementDataFile = self.mhd\n",
        "bad.vti": b'<?xml version="1.0"?><VTKFile type="ImageData"><ImageData WholeExtent="0 99999 0 99999 0 99999">',
        "bad.vtk": b"# vtk DataFile Version 3.0\nx\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 99999 99999 99999\n",
        "bad.tif": b"II*\0\xff\xff\xff\xff",
        "bad.nii": struct.pack("<i", 348) + bytes(344),
    }
    for name, content in BAD.items():
        write(folder / name, content)
        fails("info refuses " + name, 1, name, "info", folder / name)
        fails("render refuses " + name, 1, name, "render", folder / name, "-o", folder / "out.png", "--size", "8")
        fails("convert refuses " + name, 1, name, "convert", folder / name, folder / "out.nrrd")
    # 18 GB asked for by 377 bytes.
    head = bytearray(348)
    struct.pack_into("<i", head, 0, 348)
    struct.pack_into("<8h", head, 40, 3, 2100, 2100, 2100, 1, 1, 1, 1)
    struct.pack_into("<2h", head, 70, 4, 16)
    struct.pack_into("<f", head, 108, 352.0)
    head[344:348] = b"n+1\0"
    path = write(folder / "lie.nii", bytes(head) + bytes(29))
    fails("a NIfTI that asks for 18 GB", 1, "lie.nii", "info", path)
    fails("a file that is not there", 1, "absent.nrrd", "info", folder / "absent.nrrd")
    os.mkdir(folder / "bare")
    fails("an empty folder", 1, "bare", "info", folder / "bare")
    fails("raw that is too short", 1, "noise.bin", "info", folder / "noise.bin", "--raw", "100x100x100:f64")
    fails("a raw layout that is none", 2, "raw", "info", folder / "noise.bin", "--raw", "axbxc:u8")
    check(not os.path.exists(folder / "out.png") and not os.path.exists(folder / "out.nrrd"), "no output of a bad file", folder.names())

# A disk that is full: the limit on file sizes stands for it. Nothing is left behind.
with Folder() as folder:
    def small_files():
        resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))
    for ending in [".nrrd", ".vti", ".mha", ".nhdr", ".mhd", ".raw"]:
        fails("no room for " + ending, 1, "v" + ending, "make", "sphere", "--size", "32", "-o", folder / ("v" + ending), preexec_fn=small_files)
    check(folder.names() == [], "nothing is left on a full disk", folder.names())
    with open("/dev/full", "wb") as full:
        fine("make", "make", "sphere", "--size", "8", "-o", folder / "v.nrrd")
        result = run("info", "--json", folder / "v.nrrd", stdout=full)
    check(result.status == 1 and result.one_error(), "a full disk behind stdout", result)

# No output replaces what is read.
with Folder() as folder:
    def refuses(name, status, fragment, *args):
        before = {n: read(folder / n) for n in folder.names()}
        fails(name, status, fragment, *args)
        check({n: read(folder / n) for n in folder.names()} == before, name + ": all files are as they were")
    fine("make", "make", "sphere", "--size", "8", "-o", folder / "t.nhdr")
    refuses("the input's data", 2, "t.raw", "convert", folder / "t.nhdr", folder / "t.mhd", "--type", "f32")
    refuses("the input's data by name", 2, "t.raw", "convert", folder / "t.nhdr", folder / "t.raw", "--type", "f32")
    refuses("the input", 2, "t.nhdr", "convert", folder / "t.nhdr", folder / "t.nhdr")
    write(folder / "u.raw", "foreign")
    refuses("foreign data", 1, "u.raw", "convert", folder / "t.nhdr", folder / "u.mhd")
    refuses("foreign data and make", 1, "u.raw", "make", "sphere", "--size", "8", "-o", folder / "u.nhdr")
    fine("make again", "make", "sphere", "--size", "9", "-o", folder / "t.nhdr")
    fine("attached", "convert", folder / "t.nhdr", folder / "v.nrrd")
    os.symlink("v.nrrd", folder / "link.nrrd")
    volume = folder / "v.nrrd"
    refuses("-o is the input", 2, "link.nrrd", "render", volume, "-o", folder / "link.nrrd", "--size", "8")
    refuses("--depth is -o", 2, "--depth", "render", volume, "-o", folder / "p.nrrd", "--depth", folder / "./p.nrrd", "--size", "8")
    refuses("--save-scene is -o", 2, "--save-scene", "render", volume, "-o", folder / "p.png", "--save-scene", folder / "p.png", "--size", "8")
    refuses("--save-scene is the input", 2, "--save-scene", "render", volume, "-o", folder / "p.png", "--save-scene", volume, "--size", "8")
    fails("--stats xml", 2, "json", "render", volume, "-o", folder / "p.png", "--stats", "xml")
    fine("p", "render", volume, "-o", folder / "p.png", "--size", "8")
    fine("q", "render", volume, "-o", folder / "q.png", "--size", "9x8")
    result = fails("compare sizes", 1, "size", "compare", folder / "p.png", folder / "q.png", "--json")
    told = result.json()
    check(told["same_size"] is False and told["differing_pixels"] == 72 and told["psnr"] == 0, "compare --json of unlike sizes", result)

# Every fact of the real data that can be read off `info`.
FACTS = {  # dims, type, min, max, mean, non-zero; None: not recorded
    "aneurism.nrrd": ([256, 256, 256], "u8", 0, 255, 1.069210, 168948),
    "bonsai.nii.gz": ([256, 256, 256], "u8", 0, 255, 13.464758, 3386236),
    "engine.nhdr": ([256, 256, 128], "u8", 0, 255, 22.348768, 5198360),
    "neghip.nrrd": ([64, 64, 64], "u8", 0, 255, 18.402775, 121586),
    "tooth.nhdr": ([103, 94, 161], "u16", 0, 1300, 526.871014, 1558793),
    "vishuman_head.nrrd": ([512, 512, 234], "u8", 0, 255, 10.467327, 13211212),
    "cthead": ([256, 256, 99], "u8", 0, 255, 31.484447, 6366912),
    "template_T2.nrrd": ([117, 159, 126], "f32", 0, 710.7, None, None),
    "inia19-t1-brain.nii.gz": ([168, 206, 128], "f32", 0, 383.2, None, None),
    "HeadMRVolume.mhd": ([48, 62, 42], "u8", 0, 255, 24.468222, 123631),
    "frogtissue.mhd": ([500, 470, 136], "u8", 0, 29, 0.384214, 1156957),
    "ironProt.vtk": ([68, 68, 68], "u8", 0, 255, None, None),
    "hydrogen.vti": ([64, 64, 64], "f32", 0, 1, None, None),
    "isabel_speed.vti": ([125, 125, 25], "f64", 0, 76.5653, None, None), # as its own RangeMax says
    "pet_dicom": ([128, 128, 299], None, None, None, None, None),
    "carotid_velocity.nrrd": ([76, 49, 45], "f32", 0, 22.6949, 0.167487, None),
    "wind.nrrd": ([41, 35, 15], "f32", 0.268123, 78.907, 20.598614, None),
}
for name, (dims, kind, least, most, mean, nonzero) in FACTS.items():
    path = os.path.join(DATA, name)
    if not os.path.exists(path):
        skip("facts of " + name, "no data folder")
        continue
    told = info(path)
    near = lambda a, b, digits: b is None or (a is not None and abs(a - b) <= 0.51 * 10 ** -digits)
    places = lambda value: len(str(value).split(".")[1]) if value is not None and "." in str(value) else 0
    check(told.get("dims") == dims and (kind is None or told["type"] == kind) and near(told["min"], least, places(least) or 9) and
          near(told["max"], most, places(most) or 9) and near(told["mean"], mean, 6) and (nonzero is None or told["nonzero"] == nonzero),
          "facts of " + name, told)
finish()
