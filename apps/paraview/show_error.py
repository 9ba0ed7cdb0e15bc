"""Shows the output of compare_fields (.vtp) in ParaView: where a field is wrong, and by how much.

    xvfb-run -a -s -noreset pvbatch show_error.py error.vtp picture.png
    xvfb-run -a -s -noreset pvbatch show_error.py error.vtp picture.png --array radiosity_error_relative
    xvfb-run -a -s -noreset pvbatch show_error.py error.vtp picture.png --array radiosity_error_rgb:1

Absolute and relative errors (_error_absolute or _error_relative in the name) get a logarithmic scale, others (signed
ones) a scale with 0 in the middle: blue is too dark, red too bright.
"""
import os
import sys

if "__file__" in globals():
    sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import difusa_view as dv


def main(arguments):
    options = dv.parser(__doc__, "show_error.py")
    options.add_argument("--array", metavar="NAME", help="point array, or one of its components, as in `NAME:0` (the "
                                                         "first whose name ends in _error_absolute)")
    options.add_argument("--decades", type=float, default=4.0, metavar="N", help="length of a logarithmic scale (4)")
    dv.add_range(options)
    options = options.parse_args(arguments)
    if not options.decades > 0.0:
        raise dv.ViewError("--decades %g: takes a number greater than 0" % options.decades)

    field = dv.Field(options.file)
    points = field.data.GetPointData()
    names = [points.GetArrayName(i) for i in range(points.GetNumberOfArrays())]
    name = options.array or next((n for n in names if n.endswith("_error_absolute")), None)
    if name is None:
        raise dv.ViewError("%s: has no point array that ends in _error_absolute; it has %s; choose one with --array"
                           % (options.file, ", ".join(names) or "none"))
    base, component = dv.split_component(name)
    if component is None and field.array(base, None).GetNumberOfComponents() == 3:
        name += ":1" # green contributes most of the luminance
    view = dv.new_view(options)
    display = dv.show_surface(field, view, options.both_sides)
    if "_error_absolute" in base or "_error_relative" in base:
        dv.colour_by(field, view, display, name, "Viridis (matplotlib)", options.range, log_decades=options.decades)
    else:
        dv.colour_by(field, view, display, name, "Cool to Warm", options.range, centre=0.0)
    dv.aim(view, field, options)
    dv.save(view, options)


if __name__ == "__main__":
    dv.run(main)
