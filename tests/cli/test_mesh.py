# SPDX-License-Identifier: MIT
"""mesh: surfaces in files that other programs read, what is told of them, what is refused."""
import json
import math
import os
import shutil
import struct
import subprocess

from harness import DATA, Folder, check, fails, fine, finish, nrrd, read, run, skip

# Reads surfaces with VTK and prints what it found: an interpreter that has it, which need not be ours.
READER = """
import json, sys, vtk
readers = {"ply": vtk.vtkPLYReader, "stl": vtk.vtkSTLReader, "obj": vtk.vtkOBJReader, "vtp": vtk.vtkXMLPolyDataReader}
found = {}
for path in sys.argv[1:]:
    reader = readers[path.rsplit(".", 1)[1]]()
    reader.SetFileName(path)
    reader.Update()
    surface = reader.GetOutput()
    edges = vtk.vtkFeatureEdges()
    edges.SetInputData(surface)
    edges.FeatureEdgesOff()
    edges.ManifoldEdgesOff()
    edges.Update()
    mass = vtk.vtkMassProperties()
    mass.SetInputData(surface)
    mass.Update()
    data = surface.GetPointData()
    found[path] = {"points": surface.GetNumberOfPoints(), "triangles": surface.GetNumberOfPolys(), "bounds": surface.GetBounds(), "volume": mass.GetVolume(),
                   "bad_edges": edges.GetOutput().GetNumberOfCells(), "normals": data.GetNormals() is not None,
                   "isovalues": list(data.GetArray("isovalue").GetRange()) if data.HasArray("isovalue") else None}
print(json.dumps(found))
"""


def python_with_vtk():
    for name in ["/usr/bin/python3", shutil.which("python3")]:
        if name and os.path.exists(name) and subprocess.run([name, "-c", "import vtk"], capture_output=True, check=False).returncode == 0:
            return name
    return None


vtk = python_with_vtk()

with Folder() as folder:
    fine("a sphere to cut", "make", "sphere", "--size", "40", "-o", folder / "s.nrrd")
    paths = [folder / ("s." + ending) for ending in ("ply", "stl", "obj", "vtp")]
    told = {}
    for path in paths:
        result = fine("mesh to " + path[-3:], "mesh", folder / "s.nrrd", "--isovalue", "0", "-o", path, "--stats", "json")
        told = result.json()
        check(not result.err, "nothing on standard error", result)
    check(list(told) == ["load_ms", "extract_ms", "write_ms", "vertices", "triangles", "open_edges", "bounds", "surfaces"], "the keys of the contract", told)
    check(told["vertices"] - told["triangles"] / 2 == 2 and told["open_edges"] == 0, "a closed surface without holes: V - E + F is 2", told)
    check(all(math.isclose(abs(b), 0.7, rel_tol=0.01) for b in told["bounds"]), "world bounds", told)
    check(told["surfaces"] == [{"isovalue": 0.0, "vertices": told["vertices"], "triangles": told["triangles"]}], "each surface is told", told)
    check(len(read(paths[1])) == 84 + 50 * told["triangles"], "STL has its triangles")
    if vtk:
        done = subprocess.run([vtk, "-c", READER] + paths, capture_output=True, text=True, check=False)
        check(done.returncode == 0, "VTK reads them", done.stderr)
        for path, facts in (json.loads(done.stdout) if done.returncode == 0 else {}).items():
            kind = path[-3:]
            check(facts["triangles"] == told["triangles"] and facts["points"] == told["vertices"], "VTK finds the same counts in " + kind, facts)
            check(all(math.isclose(a, b, rel_tol=1e-5) for a, b in zip(facts["bounds"], told["bounds"])), "the same bounds in " + kind, facts)
            check(facts["bad_edges"] == 0, "no edge of one or three triangles in " + kind, facts)
            check(math.isclose(facts["volume"], 4 / 3 * math.pi * 0.343, rel_tol=0.01), "it encloses a ball in " + kind, facts)
            check(facts["normals"] == (kind != "stl"), "normals in " + kind, facts)
        result = fine("two surfaces", "mesh", folder / "s.nrrd", "--isovalue", "0,0.25", "-o", folder / "two.vtp", "-q")
        facts = json.loads(subprocess.run([vtk, "-c", READER, folder / "two.vtp"], capture_output=True, text=True, check=True).stdout)[folder / "two.vtp"]
        check(facts["isovalues"] == [0, 0.25] and facts["bad_edges"] == 0, "each vertex has its isovalue", facts)
    else:
        skip("VTK reads them", "no python3 with vtk")
    first = read(paths[0])
    for threads in 1, 3:
        fine("%d threads" % threads, "mesh", folder / "s.nrrd", "--isovalue", "0", "-o", folder / "t.ply", "--threads", threads)
        check(read(folder / "t.ply") == first, "the same bytes on %d threads" % threads)
    plain = told["triangles"]
    result = fine("a tolerance", "mesh", folder / "s.nrrd", "--isovalue", "0", "--tolerance", "0.002", "-o", folder / "t.ply", "--stats", "json")
    check(result.json()["triangles"] > plain and result.json()["open_edges"] == 0, "a tolerance adds triangles", result)

    result = fine("the isovalue is chosen", "mesh", folder / "s.nrrd", "-o", folder / "auto.stl")
    check("was chosen from the data" in result.err, "and told", result)
    check(not fine("--quiet", "mesh", folder / "s.nrrd", "-o", folder / "auto.stl", "-q").err, "--quiet is quiet")
    result = fine("nothing there", "mesh", folder / "s.nrrd", "--isovalue", "7", "-o", folder / "none.ply")
    check("nothing has the isovalue 7" in result.err and b"element vertex 0\n" in read(folder / "none.ply"), "an empty surface is told", result)
    result = fine("text", "mesh", folder / "s.nrrd", "--isovalue", "0", "-o", folder / "t.ply", "--stats")
    check("open edges" in result.err and "triangles" in result.err and not result.out, "--stats text goes to standard error", result)
    result = fine("a mirror placement and spacing", "mesh", nrrd(folder / "m.nrrd", [3, 3, 3], "B", [9 * (i == 13) for i in range(27)]), "--isovalue", "3", "--spacing", "1,2,3",
                  "-o", folder / "m.ply", "--stats", "json")
    check(all(math.isclose(a, b, abs_tol=1e-6) for a, b in zip(result.json()["bounds"], [1 - 2 / 3, 1 + 2 / 3, 2 - 4 / 3, 2 + 4 / 3, 3 - 2, 3 + 2])), "--spacing counts", result)

    before = folder.names()
    fails("no output", 2, "-o NAME.ply", "mesh", folder / "s.nrrd")
    fails("an ending that is not known", 2, ".ply, .stl, .obj or .vtp", "mesh", folder / "s.nrrd", "-o", folder / "x.foo")
    fails("no folder", 1, "no folder", "mesh", folder / "s.nrrd", "-o", folder / "nowhere/x.ply")
    fails("no number", 2, "--isovalue", "mesh", folder / "s.nrrd", "--isovalue", "bone", "-o", folder / "x.ply")
    fails("too many", 2, "at most 16", "mesh", folder / "s.nrrd", "--isovalue", ",".join(["1"] * 17), "-o", folder / "x.ply")
    fails("no file", 1, "not-there", "mesh", folder / "not-there.nrrd", "-o", folder / "x.ply")
    fails("a flat volume", 1, "flat", "mesh", nrrd(folder / "flat.nrrd", [4, 4, 1], "B", range(16)), "--isovalue", "3", "-o", folder / "x.ply")
    os.remove(folder / "flat.nrrd")
    check(folder.names() == before, "no file after a failure", folder.names())

# Real volumes: nothing crashes, and the surfaces have about the size that they have elsewhere (VTK's flying edges: 869353 and 249188).
for name, isovalue, triangles in ("bonsai.nii.gz", "40", 869353), ("aneurism.nrrd", "48.5", 249188):
    if not DATA or not os.path.exists(os.path.join(DATA, name)):
        skip(name, "no such file in PELLUCID_TEST_DATA")
        continue
    with Folder() as folder:
        result = fine("mesh of " + name, "mesh", os.path.join(DATA, name), "--isovalue", isovalue, "-o", folder / "m.stl", "--stats", "json", "-q")
        check(abs(result.json()["triangles"] / triangles - 1) < 0.02, name + " has its triangles", result)
        check(struct.unpack("<I", read(folder / "m.stl")[80:84])[0] == result.json()["triangles"], "and so has the file")

result = run("mesh", "--help")
check(result.status == 0 and "--isovalue" in result.text and "--tolerance" in result.text, "mesh --help", result)
finish()
