# SPDX-License-Identifier: MIT
"""From process start to a PNG through VTK in Python, as a careful user would write it: only the modules that are needed, its fastest mapper
on a machine without a GPU, the raw volume read by VTK. Timed from outside.

  PEERS_DATA=dir xvfb-run -a /usr/bin/python3 vtk_still.py SCENE FILE.png [--shade]
"""
import json, os, sys
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  (registers the OpenGL classes)
import vtkmodules.vtkRenderingVolumeOpenGL2  # noqa: F401
from vtkmodules.vtkCommonDataModel import vtkPiecewiseFunction
from vtkmodules.vtkIOImage import vtkImageReader2, vtkPNGWriter
from vtkmodules.vtkRenderingCore import vtkColorTransferFunction, vtkRenderer, vtkRenderWindow, vtkVolume, vtkVolumeProperty, vtkWindowToImageFilter
from vtkmodules.vtkRenderingVolume import vtkFixedPointVolumeRayCastMapper

with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "scenes.json"), encoding="utf-8") as f:
    doc = json.load(f)
scene = next(s for s in doc["scenes"] if s["name"] == sys.argv[1])
volume = doc["volumes"][scene["volume"]]

reader = vtkImageReader2()
reader.SetFileName(os.path.join(os.environ["PEERS_DATA"], scene["volume"] + ".raw"))
reader.SetFileDimensionality(3)
reader.SetDataExtent(0, volume["dims"][0] - 1, 0, volume["dims"][1] - 1, 0, volume["dims"][2] - 1)
reader.SetDataSpacing(*volume["spacing"])
if volume["type"] == "uint8":
    reader.SetDataScalarTypeToUnsignedChar()
else:
    reader.SetDataScalarTypeToFloat()
    reader.SetDataByteOrderToLittleEndian()

opacity, color, prop = vtkPiecewiseFunction(), vtkColorTransferFunction(), vtkVolumeProperty()
for point in scene["opacity"]:
    opacity.AddPoint(*point)
for point in scene["color"]:
    color.AddRGBPoint(*point)
prop.SetScalarOpacity(opacity)
prop.SetColor(color)
prop.SetScalarOpacityUnitDistance(doc["unit_distance"])
prop.SetInterpolationTypeToLinear()
if "--shade" in sys.argv:
    light = doc["shading"]
    prop.ShadeOn()
    prop.SetAmbient(light["ambient"])
    prop.SetDiffuse(light["diffuse"])
    prop.SetSpecular(light["specular"])
    prop.SetSpecularPower(light["power"])

mapper = vtkFixedPointVolumeRayCastMapper()
mapper.SetInputConnection(reader.GetOutputPort())
mapper.AutoAdjustSampleDistancesOff()
mapper.LockSampleDistanceToInputSpacingOff()
mapper.SetSampleDistance(scene["step"] * min(volume["spacing"]))
mapper.SetInteractiveSampleDistance(scene["step"] * min(volume["spacing"]))
mapper.SetImageSampleDistance(1.0)
prop_volume = vtkVolume()
prop_volume.SetMapper(mapper)
prop_volume.SetProperty(prop)

renderer, window = vtkRenderer(), vtkRenderWindow()
renderer.AddVolume(prop_volume)
window.SetOffScreenRendering(1)
window.SetMultiSamples(0)
window.SetDesiredUpdateRate(1e-5)
window.SetSize(*scene["size"])
window.AddRenderer(renderer)
camera = renderer.GetActiveCamera()
camera.SetFocalPoint(*scene["camera"]["focal"])
camera.SetPosition(*scene["camera"]["position"])
camera.SetViewUp(*scene["camera"]["up"])
camera.SetViewAngle(scene["camera"]["view_angle"])
renderer.ResetCameraClippingRange()

grab = vtkWindowToImageFilter()
grab.SetInput(window)
grab.ReadFrontBufferOff()
writer = vtkPNGWriter()
writer.SetFileName(sys.argv[2])
writer.SetInputConnection(grab.GetOutputPort())
writer.Write()
