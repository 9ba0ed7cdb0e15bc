"""use_macro.py MACRO FILE.vtp PICTURE.png MATERIALS.png: what a person has in ParaView's window after opening a file and
clicking the macro, from in front of the Cornell box; and after choosing material_id in the list of arrays."""
import sys

from paraview import simple

macro, file, picture, materials = sys.argv[1:5]
size = [400, 400]
simple._DisableFirstRenderCameraReset()
view = simple.GetActiveViewOrCreate("RenderView")
view.ViewSize = size
view.OrientationAxesVisibility = 0
view.UseColorPaletteForBackground = 0
view.Background = [0.2, 0.2, 0.25]
reader = simple.OpenDataFile(file)
simple.SetActiveSource(reader)
with open(macro) as script:
    exec(compile(script.read(), macro, "exec"), {}) # as ParaView does

bounds = reader.GetDataInformation().GetBounds()
view.CameraPosition = [0.278, 0.273, -0.8]
view.CameraFocalPoint = [(bounds[2 * k] + bounds[2 * k + 1]) / 2 for k in range(3)]
view.CameraViewUp = [0.0, 1.0, 0.0]
view.CameraViewAngle = 40.0
simple.SaveScreenshot(picture, view, ImageResolution=size)

display = simple.GetDisplayProperties(reader, view)
simple.ColorBy(display, ("CELLS", "material_id"))
display.MapScalars = 1
colours = simple.GetColorTransferFunction("material_id")
print("materials: %s, %d" % (list(colours.Annotations), colours.InterpretValuesAsCategories))
weighted = simple.GetColorTransferFunction("radiosity_weighted")
print("range of radiosity_weighted: %.17g to %.17g" % (weighted.RGBPoints[0], weighted.RGBPoints[-4]))
simple.SaveScreenshot(materials, view, ImageResolution=size)
