# SPDX-License-Identifier: MIT
"""One isosurface scene through VTK's flying edges; prints one JSON line.

  PEERS_DATA=dir xvfb-run -a /usr/bin/python3 vtk_iso.py SCENE [--frames N] [--out FILE.png]

vtkFlyingEdges3D (on all cores, with normals), then triangles on whatever GL is there. frame_ms: the orbit, drawing only. edit_ms: a new
isovalue each frame, that is extract, upload, draw.
"""
import argparse, os, time
import vtk
from peers_common import *

ap = argparse.ArgumentParser()
ap.add_argument("scene")
ap.add_argument("--threads", type=int, default=os.cpu_count())
ap.add_argument("--frames", type=int, help="frames of the orbit and isovalues to time")
ap.add_argument("--out", default="")
a = ap.parse_args()

doc, scene = load_scene(a.scene)
assert scene["kind"] == "iso"
doc["frames"] = a.frames or doc["frames"]
vtk.vtkSMPTools.Initialize(a.threads)
image = load_image(scene)
stage = Stage(doc, scene)
light, iso = doc["shading"], scene["iso"]

t0 = time.perf_counter()
fe = vtk.vtkFlyingEdges3D()
fe.SetInputData(image)
fe.SetValue(0, iso)
fe.ComputeNormalsOn()
fe.ComputeGradientsOff()
fe.ComputeScalarsOff()
fe.Update()
m = vtk.vtkPolyDataMapper()
m.SetInputConnection(fe.GetOutputPort())
m.ScalarVisibilityOff()
actor = vtk.vtkActor()
actor.SetMapper(m)
p = actor.GetProperty()
p.SetColor(*scene["color"])
p.SetInterpolationToPhong()
p.SetAmbient(light["ambient"])
p.SetDiffuse(light["diffuse"])
p.SetSpecular(light["specular"])
p.SetSpecularPower(light["power"])
stage.ren.AddActor(actor)
stage.draw()
first_ms = (time.perf_counter() - t0) * 1e3
stage.save(a.out)
rec = dict(program="vtk-iso", first_ms=round(first_ms, 1), frame_ms=stage.orbit(), views=stage.views)

stage.camera(0)
edits = []
for i in range(doc["frames"] + 1):
    t0 = time.perf_counter()
    fe.SetValue(0, shifted([[0, 0], [iso, 0], [0, 0]], i)[1][0])
    stage.draw()
    edits.append((time.perf_counter() - t0) * 1e3)
rec.update(edit_ms=edits[1:], triangles=fe.GetOutput().GetNumberOfPolys(), smp=vtk.vtkSMPTools.GetBackend(),
           version=vtk.vtkVersion.GetVTKVersion(), gl=gl_name(stage.win))
report(rec)
