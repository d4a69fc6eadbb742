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
    check(list(told) == ["load_ms", "extract_ms", "collapse_ms", "write_ms", "vertices", "triangles", "flat_triangles", "open_edges", "bounds", "surfaces"], "the keys of the contract", told)
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
    fails("no value reaches it", 1, "no value reaches the isovalue 7; the values go from", "mesh", folder / "s.nrrd", "--isovalue", "7", "-o", folder / "none.ply")
    fails("nor is any below it", 1, "no value is below the isovalue -9", "mesh", folder / "s.nrrd", "--isovalue=-9", "-o", folder / "none.ply")
    result = fine("one of two is there", "mesh", folder / "s.nrrd", "--isovalue", "0,7", "-o", folder / "one.ply")
    check("no value reaches the isovalue 7" in result.err and b"comment isovalue 7\n" in read(folder / "one.ply"), "the other is told", result)
    nan = float("nan")
    fails("the least value has nothing below it", 1, "no value is below the isovalue 0; the values go from 0 to 9", "mesh", nrrd(folder / "b.nrrd", [3, 3, 3], "B", [9 * (i == 13) for i in range(27)]),
          "--isovalue", "0", "-o", folder / "none.ply")
    for isovalue in ["--isovalue=5"], []:
        fails("a constant volume", 1, "every sample is 5", "mesh", nrrd(folder / "b.nrrd", [3, 3, 3], "B", [5] * 27), *isovalue, "-o", folder / "none.ply")
        fails("a void volume", 1, "every sample is void", "mesh", nrrd(folder / "b.nrrd", [3, 3, 3], "f", [nan] * 27), *isovalue, "-o", folder / "none.ply")
    fails("voids all about", 1, "no cell without voids", "mesh", nrrd(folder / "b.nrrd", [3, 3, 3], "f", [i if i % 2 else nan for i in range(27)]), "--isovalue", "4", "-o", folder / "none.ply")
    check(not os.path.exists(folder / "none.ply"), "no file without a surface")
    # Voxels that are exactly the isovalue: a ball that is a solid without triangles that have no area, and a sheet with holes, which cannot be.
    ball = nrrd(folder / "ball.nrrd", [20, 20, 20], "B", [int(100 - 3 * math.dist((i % 20, i // 20 % 20, i // 400), (9.5, 9.5, 9.5))) for i in range(8000)])
    result = fine("an isovalue that voxels have", "mesh", ball, "--isovalue", "80", "-o", folder / "ball.stl", "--stats", "json")
    facts = result.json()
    check(facts["flat_triangles"] == 0 and facts["open_edges"] == 0 and facts["vertices"] - facts["triangles"] / 2 == 2 and not result.err, "a closed ball", result)
    corners = [struct.unpack_from("<9f", read(folder / "ball.stl"), 84 + 50 * t + 12) for t in range(facts["triangles"])]
    check(all(len({c[0:3], c[3:6], c[6:9]}) == 3 for c in corners), "no triangle has two corners at one place")
    check(len({c[i:i + 3] for c in corners for i in (0, 3, 6)}) == facts["vertices"], "no two vertices share a place")
    result = fine("a row of them", "mesh", nrrd(folder / "row.nrrd", [8, 5, 5], "B", [9 * (i // 8 == 12 and 0 < i % 8 < 6) for i in range(200)]), "--isovalue", "9", "-o", folder / "row.ply", "--stats", "json")
    check(result.json()["flat_triangles"] > 0 and "triangles have no area" in result.err, "what stays is told", result)
    # A surface that is cut off by the volume's faces.
    result = fine("a slope", "mesh", nrrd(folder / "slope.nrrd", [4, 4, 4], "B", [i % 4 for i in range(64)]), "--isovalue", "1.5", "-o", folder / "slope.ply", "--stats", "json")
    check(result.json()["open_edges"] == 12 and "12 edges have one triangle" in result.err, "is open, which is told", result)
    check(not fine("quiet", "mesh", folder / "slope.nrrd", "--isovalue", "1.5", "-o", folder / "slope.ply", "-q").err, "but not where --quiet asks for none")
    # Far from the world's zero floats are coarse.
    for ending, noted in ("stl", True), ("ply", False):
        result = fine("far away", "mesh", nrrd(folder / "far.nrrd", [3, 3, 3], "B", [9 * (i == 13) for i in range(27)], "space dimension: 3\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (5000000,0,0)"), "--isovalue", "3", "-o", folder / ("far." + ending))
        check(("coarse" in result.err) == noted, "STL alone notes it", result)
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
    fails("an isovalue twice", 2, "40 is given twice", "mesh", folder / "s.nrrd", "--isovalue", "40,0", "--isovalue", "4e1", "-o", folder / "x.ply")
    fails("too many", 2, "at most 16", "mesh", folder / "s.nrrd", "--isovalue", ",".join(["1"] * 17), "-o", folder / "x.ply")
    fails("no file", 1, "not-there", "mesh", folder / "not-there.nrrd", "-o", folder / "x.ply")
    fails("a flat volume", 1, "flat", "mesh", nrrd(folder / "flat.nrrd", [4, 4, 1], "B", range(16)), "--isovalue", "3", "-o", folder / "x.ply")
    os.remove(folder / "flat.nrrd")
    check(folder.names() == before, "no file after a failure", folder.names())

# Real volumes: nothing crashes, and the surfaces have about the size that they have elsewhere (VTK's flying edges: 907512 and 249188).
for name, isovalue, triangles in ("bonsai.nii.gz", "40.5", 907512), ("aneurism.nrrd", "48.5", 249188):
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
