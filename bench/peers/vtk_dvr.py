# SPDX-License-Identifier: MIT
"""One scene (dvr, mip or xray) through one VTK volume mapper; prints one JSON line.

  PEERS_DATA=dir xvfb-run -a /usr/bin/python3 vtk_dvr.py SCENE gpu|cpu [--shade] [--frames N] [--budget S] [--out FILE.png]

gpu: vtkGPUVolumeRayCastMapper on whatever GL is there. cpu: vtkFixedPointVolumeRayCastMapper (its finished image still goes to the screen
as one GL quad, inside the timing; it has no additive blend, so it has no X-ray). No jitter, no automatic sample distance, one ray a pixel.
The first frame is cold and is the picture saved; two more warm up, then the orbit is timed from the first view on. Edits of the transfer function are
timed at the first view.
"""
import argparse, os, time
import vtk
from peers_common import *

ap = argparse.ArgumentParser()
ap.add_argument("scene")
ap.add_argument("mode", choices=("gpu", "cpu"))
ap.add_argument("--shade", action="store_true")
ap.add_argument("--threads", type=int, default=os.cpu_count())
ap.add_argument("--frames", type=int, help="frames of the orbit and edits of the transfer function to time")
ap.add_argument("--budget", type=float, default=0, help="seconds for each timed section; slow scenes then time fewer views")
ap.add_argument("--out", default="")
a = ap.parse_args()

doc, scene = load_scene(a.scene)
doc["frames"] = a.frames or doc["frames"]
image = load_image(scene)
prop, opacity = make_property(doc, scene, a.shade)
stage = Stage(doc, scene)

t0 = time.perf_counter()
if a.mode == "gpu":
    m = vtk.vtkOpenGLGPUVolumeRayCastMapper()
    m.UseJitteringOff()
    m.SetMaxMemoryInBytes(8 << 30)
else:
    m = vtk.vtkFixedPointVolumeRayCastMapper()
    m.SetNumberOfThreads(a.threads)
    m.SetInteractiveSampleDistance(scene["world_step"])
    m.IntermixIntersectingGeometryOff()  # nothing else in the scene: spares it reading the depth buffer back
m.SetInputData(image)
m.LockSampleDistanceToInputSpacingOff()
m.AutoAdjustSampleDistancesOff()
m.SetSampleDistance(scene["world_step"])
m.SetImageSampleDistance(1.0)
{"dvr": m.SetBlendModeToComposite, "mip": m.SetBlendModeToMaximumIntensity, "xray": m.SetBlendModeToAdditive}[scene["kind"]]()
vol = vtk.vtkVolume()
vol.SetMapper(m)
vol.SetProperty(prop)
stage.ren.AddVolume(vol)
stage.draw()
first_ms = (time.perf_counter() - t0) * 1e3
stage.save(a.out)

warm_ms = warm_frame(stage, first_ms)
rec = dict(program="vtk-" + a.mode, first_ms=round(first_ms, 1), frame_ms=stage.orbit(warm_ms, a.budget), views=stage.views)

stage.camera(0)
edits = []
n = edits_for(doc["frames"], warm_ms, a.budget)
skip = 1 if n > 1 else 0  # the first edit warms up, where there is time for one
span = scene["opacity"][-1][0] - scene["opacity"][0][0]
for i in range(n + skip):
    t = time.perf_counter()
    set_opacity(opacity, shifted(scene["opacity"], i, span))
    stage.draw()
    edits.append((time.perf_counter() - t) * 1e3)
rec.update(edit_ms=edits[skip:], version=vtk.vtkVersion.GetVTKVersion(), gl=gl_name(stage.win))
report(rec)
