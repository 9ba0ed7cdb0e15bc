"""A plugin for ParaView: opens a saved transport (.difusa) and lights it anew while sliders move.

Once: Tools, Manage Plugins, Load New, this file; tick Auto Load to have it next time. Then File, Open, a .difusa that
bake_radiosity --save-transport wrote, and Apply. The list of light groups switches them on and off; a slider for each
of the first twelve, in the order of the list, sets its power as a factor on that of the bake; further sliders set the
irradiance of an added uniform sky and of an added sun, and where the sun stands. With Auto Apply (Edit, Settings) the
picture follows the sliders.

Light adds up: groups and sky are computed once, by the program relight, and the sliders only weight them. For another
place of the sun, the program traces its shadows. It must be on the PATH, or be named by the environment
variable DIFUSA_RELIGHT, or by the property Program.

Shadow rays and samples are drawn anew for each light, so a sum differs from one run of relight with all these lights
by the noise of both, which the error estimate of a bake states.

Runs in ParaView 5.11 or newer. A ParaView 5.11 with Python 3.11 or newer, such as that of Debian 12, loads no Python
plugin unless "import inspect; inspect.getargspec = inspect.getfullargspec" was run before, in a script or in its
Python shell. For scripts: LoadPlugin("difusa_relight.py", remote=False, ns=globals()), then
OpenDataFile("room.difusa"). The macro difusa_macro shows the result as it looks.
"""
import contextlib
import math
import os
import shlex
import shutil
import subprocess
import tempfile

import numpy
from paraview.util.vtkAlgorithm import VTKPythonAlgorithmBase, smproperty, smproxy
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkDataArraySelection, vtkOutputWindow
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

POWERS = 12  # sliders for the powers of light groups
STRENGTHS = 1.0  # W/m^2, at which the added sky is computed


class RelightError(Exception):
    """An error the user can fix."""


def program_named(chosen):
    """The program to run."""
    name = chosen or os.environ.get("DIFUSA_RELIGHT") or "relight"
    found = shutil.which(name)
    if found is None:
        raise RelightError("the program %s cannot be found: put it on the PATH, or name it with its path (property "
                           "Program, or environment variable DIFUSA_RELIGHT)" % name)
    return found


def read_surface(file):
    reader = vtkXMLPolyDataReader()
    reader.SetFileName(file)
    reader.Update()
    data = vtkPolyData()
    data.ShallowCopy(reader.GetOutput())
    if data.GetNumberOfPoints() == 0:
        raise RelightError("%s: ParaView finds no points in it" % file)
    return data


def values(data, name):
    """A point array as a matrix of its own, #V by #components."""
    array = data.GetPointData().GetArray(name)
    if array is None:
        raise RelightError("relight wrote no array %s: use the plugin that came with the program" % name)
    matrix = vtk_to_numpy(array).astype(float)
    return matrix.reshape(matrix.shape[0], -1)


def note(data, name):
    """The numbers of an array of the whole file."""
    array = data.GetFieldData().GetArray(name)
    return [] if array is None else [array.GetComponent(0, i) if array.GetNumberOfTuples() == 1 else array.GetValue(i)
                                     for i in range(array.GetNumberOfValues())]


def words_of(options):
    """Options as a shell splits them."""
    try:
        return shlex.split(options)
    except ValueError as error:
        raise RelightError("the property Options, %s, is not complete: %s; close its quotation marks" %
                           (options, str(error).lower())) from error


class Transport:
    """A saved transport, and what is known of the light over its surface. Light is kept as (radiosity, irradiance),
    each #V by 3."""

    def __init__(self, file, program, options):
        self.file, self.program, self.options = file, program_named(program), words_of(options)
        self.surface = self.run(["--light-groups"])
        names = self.surface.GetFieldData().GetAbstractArray("light_groups")
        if self.surface.GetPointData().GetArray("radiosity") is None or names is None:
            raise RelightError("%s: is the transport of a thermal scene, which has no lights to turn" % file)
        self.groups = names.GetValue(0).split("\n")
        self.light_of = {group: self.light(self.surface, "_of_" + group) for group in self.groups}
        self.sky, self.suns = None, {}

    def run(self, arguments):
        """What the program makes of these arguments."""
        with tempfile.TemporaryDirectory(prefix="difusa_") as folder:
            out = os.path.join(folder, "relit.vtp")
            done = subprocess.run([self.program, self.file, out, "--quiet", "--error-points", "0"] + arguments +
                                  self.options, capture_output=True, text=True, check=False)
            if done.returncode != 0:
                raise RelightError(done.stderr.strip() or "%s ended with code %d" % (self.program, done.returncode))
            return read_surface(out)

    @staticmethod
    def light(data, suffix=""):
        return values(data, "radiosity" + suffix), values(data, "irradiance" + suffix)

    def alone(self, arguments):
        """The light of an added source, all others turned off. Emission is theirs."""
        off = [word for group in self.groups for word in ("--scale", group + "=0")]
        return self.light(self.run(off + arguments))

    def of_sky(self):
        if self.sky is None:
            self.sky = self.alone(["--sky", "%.17g" % STRENGTHS])
        return self.sky

    def towards(self, azimuth, elevation):
        """The direction at an azimuth from north over east and an elevation, in degrees."""
        up = numpy.array(note(self.surface, "up") or [0.0, 0.0, 1.0])
        north = numpy.array([0.0, 1.0, 0.0]) if abs(up[2]) > 0.5 else numpy.array([0.0, 0.0, -1.0])
        north -= (north @ up) * up
        north /= numpy.linalg.norm(north)
        east = numpy.cross(north, up)
        a, e = math.radians(azimuth), math.radians(elevation)
        return math.cos(e) * (math.cos(a) * north + math.sin(a) * east) + math.sin(e) * up

    def of_sun(self, azimuth, elevation):
        """For 1 W/m^2 on a surface that faces it. Only the latest places are remembered."""
        place = (azimuth, elevation)
        if place not in self.suns:
            if len(self.suns) >= 32:
                del self.suns[next(iter(self.suns))]
            direction = ",".join("%.17g" % x for x in self.towards(azimuth, elevation))
            self.suns[place] = self.alone(["--sun", direction + ",1"])
        return self.suns[place]


def srgb(linear):
    """Linear values to bytes for display."""
    x = numpy.clip(linear, 0.0, 1.0)
    curved = numpy.where(x <= 0.0031308, 12.92 * x, 1.055 * numpy.power(x, 1.0 / 2.4) - 0.055)
    return numpy.rint(255.0 * curved).astype(numpy.uint8)


def add(data, name, matrix, components=()):
    """Sets a point array; its unit is that of the array it replaces, if any."""
    array = numpy_to_vtk(numpy.ascontiguousarray(matrix), deep=True)
    array.SetName(name)
    for i, component in enumerate(components):
        array.SetComponentName(i, component)
    old = data.GetPointData().GetArray(name)
    if old is not None and old.HasInformation():
        array.CopyInformation(old.GetInformation(), True)
    data.GetPointData().RemoveArray(name)
    data.GetPointData().AddArray(array)


def slider(name, default, least, most, meaning):
    """A number as ParaView describes it: its name is that in the panel and, without blanks, in scripts."""
    return """
<DoubleVectorProperty name="%(name)s" command="Set%(command)s" number_of_elements="1" default_values="%(default)g">
  <DoubleRangeDomain name="range" min="%(least)g" max="%(most)g"/>
  <Documentation>%(meaning)s</Documentation>
</DoubleVectorProperty>""" % {"name": name, "command": name.replace(" ", ""), "default": default, "least": least,
                              "most": most, "meaning": meaning}


def text_field(name, meaning):
    return """
<StringVectorProperty name="%s" command="Set%s" number_of_elements="1" default_values="" panel_visibility="advanced">
  <Documentation>%s</Documentation>
</StringVectorProperty>""" % (name, name, meaning)


PROPERTIES = """
<StringVectorProperty name="FileName" command="SetFileName" number_of_elements="1" panel_visibility="never">
  <FileListDomain name="files"/>
  <Documentation>The saved transport.</Documentation>
</StringVectorProperty>
<StringVectorProperty name="LightGroupsInfo" command="GetLightGroups" number_of_elements_per_command="2"
                      information_only="1" si_class="vtkSIDataArraySelectionProperty"/>
<StringVectorProperty name="LightGroups" command="GetLightGroups" information_property="LightGroupsInfo"
                      number_of_elements_per_command="2" element_types="2 0" repeat_command="1"
                      si_class="vtkSIDataArraySelectionProperty">
  <ArraySelectionDomain name="array_list">
    <RequiredProperties><Property function="ArrayList" name="LightGroupsInfo"/></RequiredProperties>
  </ArraySelectionDomain>
  <Documentation>The light groups that are on.</Documentation>
</StringVectorProperty>
""" + "".join(
    [slider("Exposure", 0.0, -6.0, 6.0, "Of display_rgb, in stops from that of the bake.")] +
    [slider("Power %d" % number, 1.0, 0.0, 4.0, "Factor on the light of group %d of the list." % number)
     for number in range(1, POWERS + 1)] +
    [slider("Sky", 0.0, 0.0, 1000.0, "Irradiance of a surface that faces an added uniform sky, W/m^2."),
     slider("Sun", 0.0, 0.0, 1000.0, "Irradiance of a surface that faces an added sun, W/m^2."),
     slider("Azimuth", 180.0, 0.0, 360.0, "Of the added sun, degrees from north over east."),
     slider("Elevation", 45.0, 0.0, 90.0, "Of the added sun, degrees above the horizon."),
     text_field("Options", "Further options of relight, such as --output-spacing 0.05."),
     text_field("Program", "The program relight, with its path; without it, that of DIFUSA_RELIGHT or on the PATH.")])


class Sliders:
    """A setter for each of the sliders of powers, as ParaView calls them."""

    def set(self, name, value):
        if getattr(self, name) != value:
            setattr(self, name, value)
            self.Modified()

    def set_power(self, number, value):
        if self.powers[number - 1] != value:
            self.powers[number - 1] = value
            self.Modified()


for _number in range(1, POWERS + 1):
    setattr(Sliders, "SetPower%d" % _number, lambda self, value, number=_number: self.set_power(number, value))


@smproxy.reader(name="DifusaTransport", label="difusa transport", extensions="difusa",
                file_description="Transports saved by difusa")
@smproperty.xml(PROPERTIES)
class DifusaTransport(Sliders, VTKPythonAlgorithmBase):
    def __init__(self):
        super().__init__(nInputPorts=0, nOutputPorts=1, outputType="vtkPolyData")
        self.file = self.program = self.options = ""
        self.sky = self.sun = 0.0
        self.azimuth, self.elevation, self.stops = 180.0, 45.0, 0.0
        self.powers = [1.0] * POWERS
        self.groups = vtkDataArraySelection()
        self.groups.AddObserver("ModifiedEvent", lambda *_: self.Modified())
        self.transport, self.transport_of = None, None

    def SetFileName(self, name):
        self.set("file", name or "")

    def GetLightGroups(self):
        return self.groups

    def SetExposure(self, stops):
        self.set("stops", stops)

    def SetSky(self, irradiance):
        self.set("sky", irradiance)

    def SetSun(self, irradiance):
        self.set("sun", irradiance)

    def SetAzimuth(self, degrees):
        self.set("azimuth", degrees)

    def SetElevation(self, degrees):
        self.set("elevation", degrees)

    def SetOptions(self, options):
        self.set("options", options or "")

    def SetProgram(self, program):
        self.set("program", program or "")

    def load(self):
        """The transport of the file as it is now."""
        if not os.path.isfile(self.file):
            raise RelightError("%s: there is no such file" % self.file)
        key = (self.file, os.path.getmtime(self.file), self.program, self.options)
        if key != self.transport_of:
            self.transport, self.transport_of = None, None
            self.transport = Transport(self.file, self.program, self.options)
            self.transport_of = key
            self.list_groups()

    def list_groups(self):
        """Those of the transport and no others, in its order, which is that of the sliders. Groups of the same name
        stay on or off."""
        listed = [self.groups.GetArrayName(i) for i in range(self.groups.GetNumberOfArrays())]
        if listed != self.transport.groups:
            off = {group for group in listed if not self.groups.ArrayIsEnabled(group)}
            self.groups.RemoveAllArrays()
            for group in self.transport.groups:
                self.groups.AddArray(group, group not in off)

    @contextlib.contextmanager
    def errors_shown(self):
        """What goes wrong is said in ParaView's window, and not as a trace of calls."""
        self.failed = False
        try:
            yield
        except RelightError as error:
            self.failed = True
            vtkOutputWindow.GetInstance().DisplayErrorText("difusa: %s\n" % error)

    def RequestInformation(self, request, inInfo, outInfo):
        with self.errors_shown():
            self.load()
        return 0 if self.failed else 1

    def RequestData(self, request, inInfo, outInfo):
        with self.errors_shown():
            self.load()
            vtkPolyData.GetData(outInfo, 0).ShallowCopy(self.lit())
        return 0 if self.failed else 1

    def weights(self):
        """Factor, radiosity and irradiance of each light that is on."""
        lights = []
        for i, group in enumerate(self.transport.groups):
            power = self.powers[i] if i < POWERS else 1.0
            if power > 0.0 and self.groups.ArrayIsEnabled(group):
                lights.append((power,) + self.transport.light_of[group])
        if self.sky > 0.0:
            lights.append((self.sky / STRENGTHS,) + self.transport.of_sky())
        if self.sun > 0.0:
            lights.append((self.sun,) + self.transport.of_sun(self.azimuth, self.elevation))
        return lights

    def lit(self):
        surface = self.transport.surface
        B = numpy.zeros((surface.GetNumberOfPoints(), 3))
        H = numpy.zeros_like(B)
        for factor, radiosity, irradiance in self.weights():
            B += factor * radiosity
            H += factor * irradiance
        data = vtkPolyData()
        data.ShallowCopy(surface)
        kept = {"radiosity", "irradiance", "radiosity_weighted", "irradiance_weighted", "luminance", "illuminance",
                "display_rgb", "reflectance"}
        points = data.GetPointData()
        for name in [points.GetArrayName(i) for i in range(points.GetNumberOfArrays())]:
            if name not in kept and name != "Normals":
                points.RemoveArray(name)  # of the light of the bake
        add(data, "radiosity", B, "RGB")
        add(data, "irradiance", H, "RGB")
        weights = numpy.array(note(surface, "luminance_weights"))
        efficacy = note(surface, "lumens_per_watt")
        if efficacy:
            add(data, "luminance", efficacy[0] / math.pi * (B @ weights))
            add(data, "illuminance", efficacy[0] * (H @ weights))
        else:
            add(data, "radiosity_weighted", B @ weights)
            add(data, "irradiance_weighted", H @ weights)
        add(data, "display_rgb", srgb(note(surface, "display_exposure")[0] * 2.0 ** self.stops * B), "RGB")
        return data
