"""A macro for ParaView's window: shows the selected output of difusa as it looks, without a script to be run each time.

Once: Macros, Import New Macro, this file. Then select a .vtp or .pvd in the Pipeline Browser, press Apply, and click
difusa_macro in the toolbar. Back faces are culled, so that one sees into rooms; ParaView's own lighting is off; colours
are display_rgb, or the first scalar of a file that has no such array. In the list of arrays to colour by, scalars then
have a range that a few extreme values do not spoil, and material_id has the names of the materials.
"""
from paraview import servermanager, simple, vtk

# Of materials, over and over: neighbours differ in hue and lightness.
COLOURS = ((0.85, 0.85, 0.82), (0.80, 0.25, 0.20), (0.30, 0.60, 0.30), (0.95, 0.80, 0.30), (0.25, 0.45, 0.75),
           (0.60, 0.40, 0.65), (0.90, 0.55, 0.25), (0.45, 0.75, 0.75), (0.55, 0.40, 0.30), (0.95, 0.65, 0.75))


def unlit(arrays):
    """The numbers of the points where nothing emits, if there are any: beside a lamp all else is dark."""
    emission = arrays.GetArray("emission")
    points = range(arrays.GetNumberOfTuples())
    if emission is None:
        return points
    width = emission.GetNumberOfComponents()
    return [i for i in points if not any(emission.GetComponent(i, k) > 0.0 for k in range(width))] or points


def extremes(array, points):
    """The range of the finite values at the points without half a percent at either end; none if they are alike."""
    values = sorted(v for v in (array.GetValue(i) for i in points) if v - v == 0.0)
    if not values:
        return None
    low, high = values[int(0.005 * (len(values) - 1))], values[int(0.995 * (len(values) - 1) + 0.5)]
    return (low, high) if low < high else None


def prepare_scalars(arrays):
    """Colour map and range of each point array of one component; their names."""
    names, points = [], unlit(arrays)
    for i in range(arrays.GetNumberOfArrays()):
        array = arrays.GetArray(i)
        if array is None or array.GetNumberOfComponents() != 1:
            continue
        names.append(array.GetName())
        colours = simple.GetColorTransferFunction(array.GetName())
        colours.AutomaticRescaleRangeMode = "Never"
        colours.ApplyPreset("Inferno (matplotlib)", True)
        limits = extremes(array, points)
        if limits:
            colours.RescaleTransferFunction(*limits)
    return names


def prepare_materials(data):
    """Names for the numbers of the materials."""
    names, numbers = data.GetFieldData().GetAbstractArray("material_names"), data.GetCellData().GetArray("material_id")
    if names is None or numbers is None:
        return
    names = names.GetValue(0).split("\n")
    there = sorted({int(numbers.GetValue(i)) for i in range(numbers.GetNumberOfTuples())})
    colours = simple.GetColorTransferFunction("material_id")
    colours.InterpretValuesAsCategories = 1
    colours.Annotations = [text for k in there for text in (str(k), names[k] if k < len(names) else str(k))]
    colours.IndexedColors = [part for i in range(len(there)) for part in COLOURS[i % len(COLOURS)]]


def show_as_it_looks(source, view):
    source.UpdatePipeline()
    data = servermanager.Fetch(source)
    if not isinstance(data, vtk.vtkPolyData) or data.GetNumberOfPoints() == 0:
        raise RuntimeError("the selected source has no surface: select a .vtp or .pvd that difusa wrote")
    display = simple.Show(source, view)
    display.Representation = "Surface"
    display.Ambient, display.Diffuse, display.Specular = 1.0, 0.0, 0.0
    display.BackfaceRepresentation = "Cull Backface"
    display.InterpolateScalarsBeforeMapping = 1
    scalars = prepare_scalars(data.GetPointData())
    prepare_materials(data)
    if data.GetPointData().GetArray("display_rgb") is not None:
        simple.ColorBy(display, ("POINTS", "display_rgb"))
        display.MapScalars = 0
    elif scalars:
        simple.ColorBy(display, ("POINTS", scalars[0]))
        display.MapScalars = 1
        display.SetScalarBarVisibility(view, True)
    simple.Render(view)


selected = simple.GetActiveSource()
if selected is None:
    raise RuntimeError("nothing is selected: open a .vtp or .pvd that difusa wrote, and select it in the Pipeline Browser")
show_as_it_looks(selected, simple.GetActiveViewOrCreate("RenderView"))
