"""Shows the output of bake_radiosity (.vtp) in ParaView, as it would look or in false colours.

    xvfb-run -a -s -noreset pvbatch show_bake.py out.vtp picture.png                      # display_rgb, or the temperature of a thermal scene
    xvfb-run -a -s -noreset pvbatch show_bake.py out.vtp picture.png --array radiosity_weighted    # W/m^2, with a scale bar
    xvfb-run -a -s -noreset pvbatch show_bake.py out.vtp picture.png --array radiosity:0  # its red component

In ParaView's window: View, Python Shell, Run Script once for each; or
    import sys; sys.path.append("<prefix>/share/difusa/paraview"); import show_bake; show_bake.main(["out.vtp"])
"""
import os
import sys

if "__file__" in globals():
    sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import difusa_view as dv


def limits_without_lamps(field, name):
    """The range of the values where nothing emits, without the highest half percent: next to an area light and what is
    close to it everything else would be black. None if there are only area lights."""
    if field.data.GetPointData().GetArray("emission") is None:
        return None
    base, component = dv.split_component(name)
    emission, array = field.array("emission", 3), field.array(base, None)
    component = min(component or 0, array.GetNumberOfComponents() - 1)
    values = [array.GetComponent(i, component) for i in range(array.GetNumberOfTuples())
              if not any(emission.GetTuple3(i))]
    values = sorted(v for v in values if v - v == 0.0)
    high = values[int(0.995 * (len(values) - 1))] if values else 0.0
    return (values[0], high) if values and values[0] < high else None


def main(arguments):
    options = dv.parser(__doc__, "show_bake.py")
    options.add_argument("--array", metavar="NAME",
                         help="point array, as in `radiosity_weighted`, or one of its components, as in `radiosity:0` "
                              "(display_rgb, or temperature of a thermal scene)")
    options.add_argument("--range", nargs=2, type=float, metavar=("LEAST", "LARGEST"),
                         help="values of the lowest and highest colours (those where nothing emits, without the "
                              "highest half percent)")
    options = options.parse_args(arguments)

    field = dv.Field(options.file)
    if options.array is None:
        thermal = field.data.GetPointData().GetArray("temperature") is not None
        options.array = "temperature" if thermal else "display_rgb"
    field.array(dv.split_component(options.array)[0], None)
    view = dv.new_view(options)
    display = dv.show_surface(field, view, options.both_sides)
    if options.array == "display_rgb":
        dv.colour_directly(field, display, options.array)
    else:
        limits = options.range or limits_without_lamps(field, options.array)
        dv.colour_by(field, view, display, options.array, "Inferno (matplotlib)", limits)
    dv.aim(view, field, options)
    dv.save(view, options)


if __name__ == "__main__":
    dv.run(main)
