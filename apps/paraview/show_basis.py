"""Shows the output of inspect_basis (.vtp) in ParaView: one basis element, or a quantity of all of them.

    xvfb-run -a -s -noreset pvbatch show_basis.py basis.vtp picture.png              # element
    xvfb-run -a -s -noreset pvbatch show_basis.py basis.vtp picture.png --array sum  # 1 in the middle
    xvfb-run -a -s -noreset pvbatch show_basis.py basis.vtp picture.png --sites sites.vtp --supports

With --sites the sites are shown as dots; with --supports each element shown gets a circle of its radius around
its site, in the tangent plane.
"""
import os
import sys

if "__file__" in globals():
    sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import difusa_view as dv
from paraview import simple


def dots(sites, view):
    """A ball at each site, a small fraction of its radius."""
    glyph = simple.Glyph(Input=sites.reader, GlyphType="Sphere")
    glyph.GlyphType.Radius = 0.05
    finish(glyph, view, [1.0, 1.0, 1.0])


def circles(sites, view):
    """A circle of its radius around each site shown (all, if the file does not say which)."""
    chosen = sites.reader
    if sites.data.GetPointData().GetArray("shown") is not None:
        chosen = simple.Threshold(Input=sites.reader)
        chosen.Scalars = ["POINTS", "shown"]
        chosen.ThresholdMethod = "Above Upper Threshold"
        chosen.UpperThreshold = 1
    glyph = simple.Glyph(Input=chosen, GlyphType="Cylinder")
    glyph.GlyphType.Resolution = 64
    glyph.GlyphType.Radius = 1.0
    glyph.GlyphType.Height = 0.01
    glyph.GlyphTransform.Rotate = [0.0, 0.0, 90.0] # its axis to x, which maps to the site's normal
    glyph.OrientationArray = ["POINTS", "Normals"]
    finish(glyph, view, [1.0, 0.6, 0.2]).Representation = "Feature Edges"


def finish(glyph, view, colour):
    glyph.ScaleArray = ["POINTS", "radius"]
    glyph.ScaleFactor = 1.0
    glyph.GlyphMode = "All Points"
    display = simple.Show(glyph, view)
    display.ColorArrayName = ["POINTS", ""] # one colour
    display.DiffuseColor = display.AmbientColor = colour
    dv.without_light(display)
    display.LineWidth = 2.0
    return display


def main(arguments):
    options = dv.parser(__doc__, "show_basis.py")
    options.add_argument("--array", default="element", metavar="NAME",
                         help="element, element_N, sum, overlap or lebesgue (element)")
    options.add_argument("--sites", metavar="SITES.vtp", help="the sites (inspect_basis --sites-output)")
    options.add_argument("--supports", action="store_true", help="circles with the radii of the elements shown")
    dv.add_range(options)
    options = options.parse_args(arguments)
    if options.supports and not options.sites:
        raise dv.ViewError("--supports: needs the sites; name their file with --sites")

    field = dv.Field(options.file)
    field.array(dv.split_component(options.array)[0], None)
    view = dv.new_view(options)
    display = dv.show_surface(field, view, options.both_sides)
    values = field.values(dv.split_component(options.array)[0])
    if options.array == "sum":
        dv.colour_by(field, view, display, options.array, "Cool to Warm", options.range, centre=1.0)
    elif values and min(values) < 0.0: # the element is negative somewhere
        dv.colour_by(field, view, display, options.array, "Cool to Warm", options.range, centre=0.0)
    else:
        dv.colour_by(field, view, display, options.array, "Viridis (matplotlib)", options.range)
    dv.aim(view, field, options)
    if options.sites:
        sites = dv.Field(options.sites)
        sites.array("radius")
        sites.array("Normals", 3)
        print("sites: %d" % sites.data.GetNumberOfPoints())
        dots(sites, view)
        if options.supports:
            circles(sites, view)
    dv.save(view, options)


if __name__ == "__main__":
    dv.run(main)
