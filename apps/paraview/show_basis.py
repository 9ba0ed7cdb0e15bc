"""Shows what inspect_basis wrote (.vtp) in ParaView: an element of the basis, or what all of them come to.

    xvfb-run -a -s -noreset pvbatch show_basis.py basis.vtp picture.png                             # element
    xvfb-run -a -s -noreset pvbatch show_basis.py basis.vtp picture.png --array sum                 # 1 in the middle of the scale
    xvfb-run -a -s -noreset pvbatch show_basis.py basis.vtp picture.png --sites sites.vtp --supports

With --sites the sites are dots; with --supports around each the circle of its radius, in its tangent plane.
"""
import os
import sys

if "__file__" in globals():
    sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import difusa_view as dv
from paraview import simple


def glyphs(sites, view, size, colour):
    """2D glyphs, one at each site, of its radius times `size`, across its normal."""
    glyph = simple.Glyph(Input=sites.reader, GlyphType="2D Glyph")
    glyph.GlyphType.GlyphType = "Circle"
    glyph.GlyphType.Filled = 1 if size < 1.0 else 0
    glyph.GlyphTransform.Rotate = [0.0, 90.0, 0.0] # its normal to x, which goes to the site's normal
    glyph.OrientationArray = ["POINTS", "Normals"]
    glyph.ScaleArray = ["POINTS", "radius"]
    glyph.ScaleFactor = 2.0 * size # the circle's diameter is 1
    glyph.GlyphMode = "All Points"
    display = simple.Show(glyph, view)
    simple.ColorBy(display, None)
    display.DiffuseColor = display.AmbientColor = colour
    dv.without_light(display)
    display.LineWidth = 1.5
    return display


def main(arguments):
    options = dv.parser(__doc__, "show_basis.py")
    options.add_argument("--array", default="element", metavar="NAME",
                         help="element, element_N, sum, overlap or lebesgue (element)")
    options.add_argument("--sites", metavar="SITES.vtp", help="the sites (inspect_basis --sites-output)")
    options.add_argument("--supports", action="store_true", help="circles of the sites' radii")
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
    elif values and min(values) < 0.0: # an element that is negative somewhere
        dv.colour_by(field, view, display, options.array, "Cool to Warm", options.range, centre=0.0)
    else:
        dv.colour_by(field, view, display, options.array, "Viridis (matplotlib)", options.range)
    if options.sites:
        sites = dv.Field(options.sites)
        sites.array("radius")
        sites.array("Normals", 3)
        print("sites: %d" % sites.data.GetNumberOfPoints())
        glyphs(sites, view, 0.08, [1.0, 1.0, 1.0])
        if options.supports:
            glyphs(sites, view, 1.0, [1.0, 0.6, 0.2])
    dv.aim(view, field, options)
    dv.save(view, options)


if __name__ == "__main__":
    dv.run(main)
