# SPDX-License-Identifier: MIT
"""What the VTK peers share: scenes.json, the volume as vtkImageData, transfer functions, camera, timing, one JSON line."""
import json, os, resource, sys, time
import numpy as np
import vtk
from vtk.util import numpy_support

HERE = os.path.dirname(os.path.abspath(__file__))


def load_scene(name):
    with open(os.path.join(HERE, "..", "scenes.json"), encoding="utf-8") as f:
        doc = json.load(f)
    scene = next((s for s in doc["scenes"] if s["name"] == name), None)
    if scene is None:
        sys.exit("no such scene: %s (have %s)" % (name, " ".join(s["name"] for s in doc["scenes"])))
    scene["vol"] = doc["volumes"][scene["volume"]]
    scene["world_step"] = scene["step"] * min(scene["vol"]["spacing"])
    return doc, scene


def data_file(scene):
    root = os.environ.get("PEERS_DATA") or sys.exit("set PEERS_DATA to the folder that holds the .raw volumes")
    return os.path.join(root, scene["volume"] + ".raw")


def load_image(scene):
    vol = scene["vol"]
    raw = np.fromfile(data_file(scene), np.dtype(vol["type"]))
    assert raw.size == vol["dims"][0] * vol["dims"][1] * vol["dims"][2]
    image = vtk.vtkImageData()
    image.SetDimensions(*vol["dims"])
    image.SetSpacing(*vol["spacing"])
    scalars = numpy_support.numpy_to_vtk(raw, deep=False)
    scalars.SetName("s")
    image.GetPointData().SetScalars(scalars)
    image._keep = raw
    return image


def shifted(points, i, span=255):
    """The i-th edit of an opacity curve: all inner points move together by a few 255ths of the values' span, never by 0."""
    d = (2, -2, 4, -4, 3, -3, 1, -1, 5, -5)[i % 10] * span / 255
    return [p if k in (0, len(points) - 1) else [p[0] + d, p[1]] for k, p in enumerate(points)]


def set_opacity(function, points):
    function.RemoveAllPoints()
    for x, y in points:
        function.AddPoint(x, y)


def make_property(doc, scene, shade):
    vp = vtk.vtkVolumeProperty()
    opacity, color = vtk.vtkPiecewiseFunction(), vtk.vtkColorTransferFunction()
    set_opacity(opacity, scene["opacity"])
    for p in scene["color"]:
        color.AddRGBPoint(*p)
    vp.SetScalarOpacity(opacity)
    vp.SetColor(color)
    vp.SetScalarOpacityUnitDistance(doc["unit_distance"])
    vp.SetInterpolationTypeToLinear()
    s = doc["shading"]
    vp.SetShade(1 if shade else 0)
    vp.SetAmbient(s["ambient"])
    vp.SetDiffuse(s["diffuse"])
    vp.SetSpecular(s["specular"])
    vp.SetSpecularPower(s["power"])
    return vp, opacity


class Stage:
    """An off-screen window with one prop; frame(k) draws frame k of the orbit and returns milliseconds until it is done."""

    def __init__(self, doc, scene):
        self.doc, self.scene = doc, scene
        self.ren = vtk.vtkRenderer()
        self.ren.SetBackground(0, 0, 0)
        self.win = vtk.vtkRenderWindow()
        self.win.SetOffScreenRendering(1)
        self.win.SetMultiSamples(0)
        self.win.SetSwapBuffers(0)
        self.win.SetDesiredUpdateRate(1e-5)
        self.win.SetSize(*scene["size"])
        self.win.AddRenderer(self.ren)
        self.win.Render()  # the GL context exists before anything is timed
        self.win.WaitForCompletion()
        self.camera(0)

    def camera(self, k):
        c = self.scene["camera"]
        cam = self.ren.GetActiveCamera()
        cam.SetFocalPoint(*c["focal"])
        cam.SetPosition(*c["position"])
        cam.SetViewUp(*c["up"])
        cam.SetViewAngle(c["view_angle"])
        cam.Azimuth(self.doc["orbit_degrees"] * k)

    def draw(self):
        self.ren.ResetCameraClippingRange()
        self.win.Render()
        self.win.WaitForCompletion()

    def frame(self, k):
        t = time.perf_counter()
        self.camera(k)
        self.draw()
        return (time.perf_counter() - t) * 1e3

    def orbit(self, slow_ms=0.0, budget_s=0.0):
        """Warm up, then time the orbit. Where budget_s is set and slow_ms (a known frame time) would break it, fewer of
        the same views are timed, spread over the orbit (at least 2; 1 where it takes 9 s), after one warm-up or none."""
        n, w = self.doc["frames"], self.doc["warmup"]
        ks, warm = range(n), range(-w, 0)
        if budget_s and slow_ms * n > budget_s * 1e3:
            m = max(1 if slow_ms >= 9000 else 2, int(budget_s * 1e3 / slow_ms))
            ks = [int((i + 0.5) * n / m) for i in range(m)]
            warm = warm[-1:] if slow_ms < 5000 else []
        for k in warm:
            self.frame(k)
        ms = [self.frame(k) for k in ks]
        self.views = list(ks)
        return ms

    def save(self, path):
        """The picture on screen as a PNG, where a path was given."""
        if not path:
            return
        grab = vtk.vtkWindowToImageFilter()
        grab.SetInput(self.win)
        grab.SetInputBufferTypeToRGB()
        grab.ReadFrontBufferOff()
        grab.ShouldRerenderOff()
        w = vtk.vtkPNGWriter()
        w.SetFileName(path)
        w.SetInputConnection(grab.GetOutputPort())
        w.Write()


def gl_name(win):
    caps = win.ReportCapabilities() or ""
    return next((l.split(":", 1)[1].strip() for l in caps.splitlines() if "renderer string" in l), "?")


def edits_for(n, slow_ms, budget_s):
    """How many of n edits to time: what half the budget allows, at least 1, none where a frame takes 9 s or more."""
    return n if not budget_s else 0 if slow_ms >= 9000 else max(1, min(n, int(budget_s * 500 / slow_ms)))


def warm_frame(stage, first_ms):
    """How slow a warm frame is: the same view again, or the cold figure where another draw would only cost seconds."""
    if first_ms > 6000:
        return first_ms
    t = time.perf_counter()
    stage.draw()
    return (time.perf_counter() - t) * 1e3


def report(record):
    record["peak_mb"] = round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
    for key, value in record.items():
        if isinstance(value, list) and value and isinstance(value[0], float):
            record[key] = [round(x, 2) for x in value]
    print(json.dumps(record), flush=True)
