"""use_relight.py PLUGIN PICTURE.png FILE.difusa LIGHT.vtp...: opens a saved transport with the plugin, as a person would
in ParaView's window; turns lamp and sky and adds a sun, and compares what the plugin adds up with the sum of what
relight wrote for each of these lights. The picture is of that."""
import inspect
import sys

import numpy
from paraview import servermanager, simple
from vtkmodules.util.numpy_support import vtk_to_numpy

plugin, picture, transport = sys.argv[1:4]
# ParaView 5.11 asks for it by the name it had up to Python 3.10; with later ones it loads no plugin without this.
inspect.getargspec = getattr(inspect, "getargspec", inspect.getfullargspec)

simple._DisableFirstRenderCameraReset()
simple.LoadPlugin(plugin, remote=False, ns=globals())


def arrays(source):
    data = servermanager.Fetch(source).GetPointData()
    return {data.GetArrayName(i): vtk_to_numpy(data.GetArray(i)).astype(float) for i in range(data.GetNumberOfArrays())}


def furthest(a, b):
    return abs(a - b).max() / abs(b).max()


reader = simple.OpenDataFile(transport)
assert reader.SMProxy.GetXMLName() == "DifusaTransport", reader.SMProxy.GetXMLName()
reader.UpdatePipeline()
print("groups: %s" % list(reader.LightGroups.Available))
before = arrays(reader)

reader.Power1 = 2.0
twice = arrays(reader)
print("twice the lamp: off by %.3g" % furthest(twice["radiosity"], 2.0 * before["radiosity"]))

reader.LightGroups = []
reader.UpdatePipeline()
print("all off: at most %.3g" % arrays(reader)["radiosity"].max())

reader.LightGroups = ["lamp"]
reader.Power1, reader.Sky, reader.Sun, reader.Azimuth, reader.Elevation = 0.5, 2.0, 30.0, 0.0, 20.0
reader.Exposure = 1.0
mixed, lights = arrays(reader), [arrays(simple.OpenDataFile(file)) for file in sys.argv[4:]]
for name in sorted(mixed):
    if name in ("Normals", "reflectance"):
        print("%s: off by %.3g" % (name, furthest(mixed[name], lights[0][name])))
    elif name != "display_rgb":
        print("%s: off by %.3g" % (name, furthest(mixed[name], sum(light[name] for light in lights))))
reader.Exposure = 0.0
brighter = mixed["display_rgb"] - arrays(reader)["display_rgb"]
reader.Exposure = 1.0
print("display_rgb: brighter by %g to %g" % (brighter.min(), brighter.max()))

simple.SetActiveSource(reader)
view = simple.GetActiveViewOrCreate("RenderView")
view.ViewSize = [400, 400]
view.OrientationAxesVisibility = 0
display = simple.Show(reader, view)
simple.ColorBy(display, ("POINTS", "display_rgb"))
display.MapScalars = 0
bounds = reader.GetDataInformation().GetBounds()
view.CameraPosition = [0.278, 0.273, -0.8]
view.CameraFocalPoint = [(bounds[2 * k] + bounds[2 * k + 1]) / 2 for k in range(3)]
view.CameraViewUp = [0.0, 1.0, 0.0]
view.CameraViewAngle = 40.0
simple.SaveScreenshot(picture, view, ImageResolution=[400, 400])
