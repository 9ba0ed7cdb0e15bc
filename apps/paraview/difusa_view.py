"""Shared by the scripts in this folder: reading difusa's field files, choosing an array, colours, camera, picture.

Runs in ParaView 5.11 or newer: in pvbatch and in the Python shell of the window.
"""
import argparse
import os
import sys

from paraview import servermanager, simple, vtk

BACKGROUND = [0.2, 0.2, 0.25]


class ViewError(Exception):
    """An error the user can fix."""


class Field:
    """A .vtp file: the reader in the pipeline, and the data fetched from it."""

    def __init__(self, file):
        if not os.path.isfile(file):
            raise ViewError("%s: there is no such file" % file)
        if not file.lower().endswith(".vtp"):
            raise ViewError("%s: is not a .vtp file; difusa's programs write one if the output's name ends in .vtp" % file)
        self.file = file
        self.reader = simple.XMLPolyDataReader(registrationName=os.path.basename(file), FileName=[file])
        self.reader.UpdatePipeline()
        self.data = servermanager.Fetch(self.reader)
        if self.data is None or self.data.GetNumberOfPoints() == 0:
            raise ViewError("%s: ParaView finds no points in it" % file)

    def array(self, name, components=1):
        """The point array of that name; if there is none, an error that lists the existing ones."""
        points = self.data.GetPointData()
        found = points.GetArray(name)
        if found is None:
            there = [points.GetArrayName(i) for i in range(points.GetNumberOfArrays())]
            raise ViewError("%s: has no point array %s; it has %s" % (self.file, name, ", ".join(there) or "none"))
        if components is not None and found.GetNumberOfComponents() != components:
            raise ViewError("%s: %s has %d components, not %d; for one of them name it, as in %s:0"
                            % (self.file, name, found.GetNumberOfComponents(), components, name))
        return found

    def values(self, name, component=0):
        """The finite values of one component, in the order of the points."""
        array = self.array(name, None)
        values = (array.GetComponent(i, component) for i in range(array.GetNumberOfTuples()))
        return [v for v in values if v - v == 0.0]

    def title(self, name, component=None):
        """"radiosity_weighted, W/m^2": the name, with those of the component and the unit if the file has them."""
        array = self.array(name, None)
        title = name
        if component is not None and array.GetNumberOfComponents() > 1:
            title += " " + (array.GetComponentName(component) or str(component))
        unit = array.GetInformation().Get(vtk.vtkDataArray.UNITS_LABEL()) if array.HasInformation() else None
        return title + (", " + unit if unit else "")


def split_component(name):
    """"radiosity:1" is component 1 of radiosity; "radiosity_weighted" is component 0, unnamed."""
    base, colon, component = name.rpartition(":")
    if not colon:
        return name, None
    if not component.isdigit():
        raise ViewError("%s: the colon must be followed by a component number, from 0" % name)
    return base, int(component)


def without_light(display):
    """Shows colours unshaded."""
    display.Ambient, display.Diffuse, display.Specular = 1.0, 0.0, 0.0


def show_surface(field, view, both_sides=False):
    """The surface without ParaView's own lighting; back faces culled, to see into rooms."""
    display = simple.Show(field.reader, view)
    display.Representation = "Surface"
    without_light(display)
    display.InterpolateScalarsBeforeMapping = 1
    if not both_sides:
        display.BackfaceRepresentation = "Cull Backface"
    return display


def colour_directly(field, display, name):
    """Uses the bytes of the array as colours."""
    array = field.array(name, 3)
    if array.GetDataType() != vtk.VTK_UNSIGNED_CHAR:
        raise ViewError("%s: %s does not hold colours as bytes" % (field.file, name))
    simple.ColorBy(display, ("POINTS", name))
    display.MapScalars = 0


def colour_by(field, view, display, name, preset, limits=None, log_decades=None, centre=None):
    """Colours by one component, with a scale bar showing name and unit; prints the range of the values, and that of the
    bar.

    limits       (least, largest) of the colour scale; by default those of the values
    log_decades  a logarithmic scale of that many decades below the largest; smaller values get the lowest colour
    centre       this value gets the middle colour, and the limits are equally far on either side
    """
    name, component = split_component(name)
    array = field.array(name, None if component is not None else 1)
    if component is not None and component >= array.GetNumberOfComponents():
        raise ViewError("%s: %s has %d components, from 0" % (field.file, name, array.GetNumberOfComponents()))
    values = field.values(name, component or 0)
    if not values:
        raise ViewError("%s: no value of %s is a finite number" % (field.file, name))
    least, largest = min(values), max(values)
    title = field.title(name, component)
    print("range of %s: %.17g to %.17g" % (title, least, largest))
    low, high = limits or (least, largest)
    if centre is not None and not limits:
        reach = max(abs(least - centre), abs(largest - centre))
        low, high = centre - reach, centre + reach
    if log_decades and not limits:
        low = high * 10.0 ** -log_decades
    if log_decades and not low > 0.0:
        log_decades = None
        print("note: nothing is greater than 0: the scale is not logarithmic")
    if high - low <= 1e-9 * max(abs(low), abs(high)): # one value everywhere except for rounding
        reach = abs(low) / 2 or 1.0
        low, high = low - reach, high + reach
    print("colour bar: %.17g to %.17g%s" % (low, high, ", logarithmic" if log_decades else ""))

    simple.ColorBy(display, ("POINTS", name) if component is None else
                   ("POINTS", name, array.GetComponentName(component) or str(component)))
    display.MapScalars = 1
    colours = simple.GetColorTransferFunction(name)
    colours.AutomaticRescaleRangeMode = "Never"
    colours.UseLogScale = 0
    if not colours.ApplyPreset(preset, True):
        raise ViewError("this ParaView has no colour map %s" % preset)
    colours.RescaleTransferFunction(low, high)
    if log_decades:
        colours.MapControlPointsToLogSpace()
        colours.UseLogScale = 1
    colours.NanColor = [0.5, 0.5, 0.5]
    bar = simple.GetScalarBar(colours, view)
    bar.Title, bar.ComponentTitle = title, ""
    bar.TitleColor = bar.LabelColor = [1.0, 1.0, 1.0]
    bar.TitleFontSize = bar.LabelFontSize = 16
    bar.AutomaticLabelFormat = 0
    bar.LabelFormat = bar.RangeLabelFormat = "%.3g"
    bar.WindowLocation = "Lower Right Corner"
    bar.ScalarBarLength = 0.5
    bar.Visibility = 1


def aim(view, field, options):
    """The camera as given, or one that shows everything, looking along options.towards."""
    view.CameraViewAngle = options.view_angle
    view.CameraViewUp = options.up
    if options.eye:
        view.CameraPosition = options.eye
        view.CameraFocalPoint = options.target or centre_of(field)
    else:
        centre = centre_of(field)
        view.CameraFocalPoint = centre
        view.CameraPosition = [c - t for c, t in zip(centre, options.towards)]
        simple.ResetCamera(view)
    print("camera: eye %.9g %.9g %.9g target %.9g %.9g %.9g up %.9g %.9g %.9g angle %.9g"
          % (*view.CameraPosition, *view.CameraFocalPoint, *view.CameraViewUp, view.CameraViewAngle))


def centre_of(field):
    bounds = field.data.GetBounds()
    return [(bounds[2 * k] + bounds[2 * k + 1]) / 2 for k in range(3)]


def new_view(options):
    """The view of the window if there is one, otherwise a new one."""
    simple._DisableFirstRenderCameraReset() # as ParaView's own recorded scripts do: keeps the camera in place
    view = simple.GetActiveViewOrCreate("RenderView")
    view.ViewSize = options.size
    view.OrientationAxesVisibility = 0
    view.UseColorPaletteForBackground = 0
    view.Background = options.background
    return view


def save(view, options):
    simple.Render(view)
    if options.picture:
        simple.SaveScreenshot(options.picture, view, ImageResolution=options.size)
        if not os.path.isfile(options.picture):
            raise ViewError("%s: could not be written" % options.picture)
        print("written: %s" % options.picture)


def parser(description, what):
    """Options common to all scripts."""
    result = argparse.ArgumentParser(prog=what, description=description, allow_abbrev=False,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    result.add_argument("file", metavar="FILE.vtp", help="file written by difusa")
    result.add_argument("picture", metavar="PICTURE.png", nargs="?",
                        help="where to save the picture; optional in ParaView's window")
    result.add_argument("--size", nargs=2, type=int, default=[1000, 800], metavar=("WIDTH", "HEIGHT"))
    result.add_argument("--towards", nargs=3, type=float, default=[0.5, 1.0, -0.6], metavar=("X", "Y", "Z"),
                        help="viewing direction; everything is fitted into the picture (0.5 1 -0.6)")
    result.add_argument("--up", nargs=3, type=float, default=[0.0, 0.0, 1.0], metavar=("X", "Y", "Z"),
                        help="up direction in the picture (0 0 1)")
    result.add_argument("--eye", nargs=3, type=float, metavar=("X", "Y", "Z"), help="camera position")
    result.add_argument("--target", nargs=3, type=float, metavar=("X", "Y", "Z"),
                        help="point to look at from there (the middle of the scene)")
    result.add_argument("--view-angle", type=float, default=30.0, metavar="DEGREES", help="vertical field of view (30)")
    result.add_argument("--background", nargs=3, type=float, default=BACKGROUND, metavar=("R", "G", "B"),
                        help="background colour, 0 to 1 (0.2 0.2 0.25)")
    result.add_argument("--both-sides", action="store_true", help="do not cull back faces")
    return result


def add_range(arguments):
    arguments.add_argument("--range", nargs=2, type=float, metavar=("LEAST", "LARGEST"),
                           help="values of the lowest and highest colours (those of the data)")


def run(main):
    """Calls main with the command line arguments; reports errors on one line, exit code 2 (1 for wrong arguments)."""
    try:
        main(sys.argv[1:])
        code = 0
    except ViewError as error:
        print("error: %s" % error, file=sys.stderr)
        code = 2
    except SystemExit as exit_of_argparse:
        code = 1 if exit_of_argparse.code else 0
    sys.stdout.flush()
    sys.stderr.flush()
    if code:
        os._exit(code) # pvbatch ends with 0 whatever sys.exit says
