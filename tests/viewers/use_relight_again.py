"""use_relight_again.py PLUGIN FIRST.difusa SECOND.difusa OPTIONS LIGHT.vtp...: opens a copy of the first transport with
the plugin, with these options of relight; then the file becomes the second one, whose light groups take the place of
the first one's. Compares what the plugin adds up, half of its sky, an added sky and an added sun, with the sum of what
relight wrote for each of these lights."""
import inspect
import os
import shutil
import sys

from paraview import servermanager, simple
from vtkmodules.util.numpy_support import vtk_to_numpy

plugin, first, second, options = sys.argv[1:5]
inspect.getargspec = getattr(inspect, "getargspec", inspect.getfullargspec)  # see use_relight.py
simple.LoadPlugin(plugin, remote=False, ns=globals())


def arrays(source):
    data = servermanager.Fetch(source).GetPointData()
    return {name: vtk_to_numpy(data.GetArray(name)).astype(float) for name in ("radiosity", "irradiance")}


file = "again.difusa"
shutil.copyfile(first, file)
os.utime(file, (1, 1))
reader = simple.OpenDataFile(file)
reader.Options = options
reader.UpdatePipeline()
print("first: %s" % list(reader.LightGroups.Available))

shutil.copyfile(second, file)
reader.Exposure = 1.0
reader.UpdatePipeline()
reader.UpdatePropertyInformation()
print("then: %s" % list(reader.LightGroups.Available))

reader.LightGroups = ["sky"]
reader.Power1, reader.Sky, reader.Sun, reader.Azimuth, reader.Elevation = 0.5, 2.0, 30.0, 0.0, 20.0
mixed, lights = arrays(reader), [arrays(simple.OpenDataFile(light)) for light in sys.argv[5:]]
for name in sorted(mixed):
    wanted = sum(light[name] for light in lights)
    print("%s: off by %.3g" % (name, abs(mixed[name] - wanted).max() / wanted.max()))
