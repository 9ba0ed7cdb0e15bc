"""checks.py OUT_DIR: what ParaView and MeshLab showed and said (run.sh) against the files, by content: no picture is
compared with another. Ends with 1 and all that does not hold."""
import math
import os
import re
import sys

from field import Picture, read_ply_vertices, read_vtp

BACKGROUND = (51, 51, 64) # 0.2, 0.2, 0.25
failures = []


def check(holds, message):
    if not holds:
        failures.append(message)


class Camera:
    """From the line that the scripts print: eye, target, up, height of the view in degrees."""

    def __init__(self, log, width, height):
        text = open(log).read()
        three = r"(\S+) (\S+) (\S+)"
        found = re.search("camera: eye %s target %s up %s angle (\\S+)" % (three, three, three), text)
        n = [float(x) for x in found.groups()]
        self.eye, self.width, self.height = n[0:3], width, height
        self.forward = unit([b - a for a, b in zip(n[0:3], n[3:6])])
        self.right = unit(cross(self.forward, n[6:9]))
        self.up = cross(self.right, self.forward)
        self.scale = height / 2 / math.tan(math.radians(n[9]) / 2)

    def pixel(self, point):
        """Column and row, from the top left corner of the picture; pixel i reaches from i to i + 1."""
        d = [b - a for a, b in zip(self.eye, point)]
        depth = dot(d, self.forward)
        return (self.width / 2 + self.scale * dot(d, self.right) / depth,
                self.height / 2 - self.scale * dot(d, self.up) / depth)


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(a):
    return [x / math.sqrt(dot(a, a)) for x in a]


def row(flat, width, i):
    return flat[width * i:width * i + width]


def triangle_pixels(camera, points, corners, where):
    """(corners, pixel) of the triangles whose corners are `where` and whose middle pixel lies a pixel inside."""
    result = []
    for t in range(len(corners) // 3):
        vertices = row(corners, 3, t)
        places = [row(points, 3, v) for v in vertices]
        if not all(where(p) for p in places):
            continue
        flat = [camera.pixel(p) for p in places]
        x, y = (int(sum(q[k] for q in flat) / 3) for k in (0, 1))
        edges = [((b[0] - a[0]) * (y + 0.5 - a[1]) - (b[1] - a[1]) * (x + 0.5 - a[0])) / math.dist(a, b)
                 for a, b in zip(flat, flat[1:] + flat[:1])]
        if min(edges) > 1.0 or max(edges) < -1.0:
            result.append((vertices, (x, y)))
    return result


def check_range(log, values):
    """The range ParaView printed is that of the file, bit by bit."""
    found = re.search(r"^range of .*: (\S+) to (\S+)$", open(log).read(), re.M)
    check(found, log + ": no range")
    if found:
        printed, own = tuple(map(float, found.groups())), (min(values), max(values))
        check(printed == own, "%s: ParaView's range %s to %s, the file's %s to %s" % (log, *printed, *own))


def check_scale_bar(name, picture):
    """Labels, white, in the lower right corner."""
    white = sum(picture.at(x, y) == (255, 255, 255) for x in range(3 * picture.width // 4, picture.width)
                for y in range(picture.height // 2, picture.height))
    check(white >= 50, "%s: no labels of a scale bar: %d white pixels" % (name, white))


def check_box():
    """Every triangle of the side walls, all of which are in sight, has the colours of its corners in the file; what is
    not background is what the opening of the box covers."""
    components, arrays, cells = read_vtp("box.vtp")
    picture = Picture("box.png")
    check((picture.width, picture.height) == (400, 400), "box.png: not 400 by 400")
    camera = Camera("box.log", 400, 400)
    points, colour = arrays["points"], arrays["display_rgb"]
    # Red is at high x; at its foot the wall stands 0.0064 m further in than at its top.
    walls = {"red": lambda p: p[0] > 0.5495, "green": lambda p: p[0] < 1e-6}
    for wall, where in walls.items():
        seen = triangle_pixels(camera, points, cells["connectivity"], where)
        check(len(seen) >= 50, "box.png: only %d triangles of the %s wall are large enough" % (len(seen), wall))
        sums = [0, 0, 0]
        for vertices, (x, y) in seen:
            shown = picture.at(x, y)
            for c in range(3):
                sums[c] += shown[c]
                corners = [colour[3 * v + c] for v in vertices]
                check(min(corners) - 2 <= shown[c] <= max(corners) + 2, # rounded to bytes twice
                      "box.png: pixel %d %d of the %s wall is %s, its corners' %s" % (x, y, wall, shown, corners))
        main, others = (0, (1, 2)) if wall == "red" else (1, (0, 2))
        check(all(sums[main] > 1.5 * sums[o] for o in others), "box.png: the %s wall is %s" % (wall, sums))

    # The opening's corners in z = 0; an edge may take or leave a pixel all along.
    corners = [camera.pixel(p) for p in ((0.5528, 0, 0), (0, 0, 0), (0, 0.5488, 0), (0.556, 0.5488, 0))]
    pairs = list(zip(corners, corners[1:] + corners[:1]))
    area = abs(sum(a[0] * b[1] - a[1] * b[0] for a, b in pairs)) / 2
    perimeter = sum(math.dist(a, b) for a, b in pairs)
    background = picture.colours().get(BACKGROUND, 0)
    check(abs(400 * 400 - background - area) <= perimeter,
          "box.png: %d pixels of background, expected %d within %d" % (background, 400 * 400 - area, perimeter))


def check_luminance():
    """The more the value, the lighter the colour."""
    components, arrays, cells = read_vtp("box.vtp")
    values = arrays["radiosity_weighted"]
    check_range("luminance.log", values)
    low, high = map(float, re.search(r"^colour bar: (\S+) to (\S+)$", open("luminance.log").read(), re.M).groups())
    check(min(values) <= low < high < max(values), "luminance.log: the bar is from %g to %g" % (low, high))
    picture = Picture("luminance.png")
    check_scale_bar("luminance.png", picture)
    camera = Camera("luminance.log", 400, 400)
    seen = triangle_pixels(camera, arrays["points"], cells["connectivity"], lambda p: p[0] > 0.5495)
    light = sorted((min(values[v] for v in t), max(values[v] for v in t), dot(picture.at(*p), (0.2126, 0.7152, 0.0722)))
                   for t, p in seen)
    for i, (_, high, dark) in enumerate(light):
        for low, _, bright in light[i + 1:]:
            check(low < high or bright >= dark - 2, "luminance.png: %g is lighter than %g" % (high, low))
    check(len(light) >= 50 and light[-1][2] > light[0][2] + 10, "luminance.png: the wall is all of one colour")


def check_macro():
    """By the macro the box looks as by the script, scalars have the range of what does not emit, and material_id has a
    colour and the name for each material."""
    check(Picture("macro.png").rows == Picture("box.png").rows, "macro.png: does not look like box.png")
    log = open("macro.log").read()
    for name in ("white", "red", "green", "lamp"):
        check("'%s'" % name in log, "macro.log: no material %s" % name)
    check(re.search("^materials: .*, 1$", log, re.M), "macro.log: material_id is no category")
    components, arrays, cells = read_vtp("box.vtp")
    # Lamps do not count: beside them all else would be black.
    emission = arrays["emission"]
    values = sorted(v for i, v in enumerate(arrays["radiosity_weighted"]) if not any(emission[3 * i:3 * i + 3]))
    low, high = map(float, re.search(r"radiosity_weighted: (\S+) to (\S+)", log).groups())
    for end, name, wanted in ((low, "low", 0.005), (high, "high", 0.995)): # many may be alike: black ones
        below, up_to = sum(v < end for v in values) / len(values), sum(v <= end for v in values) / len(values)
        check(below - 0.001 <= wanted <= up_to + 0.001,
              "macro.log: %.3f to %.3f of the values are below the %s end" % (below, up_to, name))
    picture = Picture("materials.png")
    camera = Camera("box.log", 400, 400)
    walls = (lambda p: p[0] > 0.5495, lambda p: p[0] < 1e-6)
    colours = [{picture.at(*p) for _, p in triangle_pixels(camera, arrays["points"], cells["connectivity"], wall)}
               for wall in walls]
    for shown, own in zip(colours, ((0.80, 0.25, 0.20), (0.30, 0.60, 0.30))): # the second and third of the macro's
        check(len(shown) == 1 and all(abs(byte - 255 * part) <= 1 for byte, part in zip(min(shown), own)),
              "materials.png: walls are %s" % colours)


def check_courtyard():
    """Fitted: all the border is background, and what is inside is a good part of the picture in many colours."""
    picture = Picture("courtyard.png")
    check((picture.width, picture.height) == (400, 300), "courtyard.png: not 400 by 300")
    border = [picture.at(x, y) for x in range(400) for y in (0, 299)]
    border += [picture.at(x, y) for x in (0, 399) for y in range(300)]
    check(all(p == BACKGROUND for p in border), "courtyard.png: something touches the border")
    colours = picture.colours()
    share = 1 - colours.get(BACKGROUND, 0) / (400 * 300)
    check(share > 0.1, "courtyard.png: only %.3f of it is not background" % share)
    check(len(colours) > 500, "courtyard.png: %d colours" % len(colours))


def check_basis():
    components, arrays, cells = read_vtp("basis.vtp")
    for name in ("element", "sum"):
        check_range(name + ".log", arrays[name])
        check_scale_bar(name + ".png", Picture(name + ".png"))
    sites = read_vtp("sites.vtp")[1]
    count = len(sites["points"]) // 3
    check("sites: %d\n" % count in open("element.log").read(), "element.log: other number of sites than %d" % count)
    picture = Picture("element.png")
    camera = Camera("element.log", picture.width, picture.height)
    orange = sum(n for c, n in picture.colours().items() if c[0] > 200 and 100 < c[1] < 200 and c[2] < 100)
    check(orange >= 50, "element.png: no circle around the support: %d pixels" % orange)
    # The element's largest value has the lightest colours around it, but for the site's dot.
    top = max(range(len(arrays["element"])), key=lambda v: arrays["element"][v])
    x, y = (int(k) for k in camera.pixel(row(arrays["points"], 3, top)))
    around = [picture.at(x + i, y + j) for i in range(-12, 13) for j in range(-12, 13)]
    yellow = any(c[0] > 150 and c[1] > 180 and c[2] < 90 for c in around)
    check(yellow, "element.png: the top is not yellow at %d %d" % (x, y))
    # The sum is 1 but for rounding: the middle of the scale everywhere.
    picture = Picture("sum.png")
    middle = picture.at(picture.width // 2, picture.height // 2)
    check(max(middle) - min(middle) <= 4 and 210 < middle[1] < 230, "sum.png: 1 is %s, not the middle grey" % (middle,))


def check_error():
    components, arrays, cells = read_vtp("error.vtp")
    for log, name, c in (("error.log", "radiosity_error_absolute", 0), ("signed.log", "radiosity_error_rgb", 0)):
        values = [v for v in arrays[name][c::components[name]] if v == v]
        check_range(log, values)
        picture = Picture(log.replace(".log", ".png"))
        check_scale_bar(log, picture)
        check(len(picture.colours()) > 100, "%s: of few colours" % log)


def check_meshlab():
    """Number of vertices, quality's extremes, mean and histogram, colours kept."""
    own = read_ply_vertices("box.ply")
    text = open("meshlab.log").read()
    quality, count = own["quality"], len(own["x"])
    check("loaded has %d vn " % count in text, "meshlab.log: other number of vertices than %d" % count)
    least, largest, mean = map(float, re.search(r"Min (\S+) Max (\S+)\s+(?:LOG: \d\s*)?Avg (\S+)", text).groups())
    for said, value in ((least, min(quality)), (largest, max(quality)), (mean, math.fsum(quality) / count)):
        # Six digits after the point, and sums of floats.
        check(abs(said - value) <= 1e-6 + 1e-6 * abs(value), "meshlab.log: %g, expected %g" % (said, value))
    bins = {}
    for low, high, number in re.findall(r"\[\s*([0-9.]+)\.\.\s*([0-9.]+)\) :\s*(\d+)", text):
        bins.setdefault((float(low), float(high)), int(number)) # what it prints again is counted twice by it
    check(len(bins) == 8, "meshlab.log: %d bins" % len(bins))
    for (low, high), number in bins.items():
        expected = sum(low < q <= high for q in quality)  # its bins hold their upper ends, whatever it prints
        check(number == expected, "meshlab.log: %d values in %g to %g, expected %d" % (number, low, high, expected))
    again = read_ply_vertices("meshlab.ply")
    for name in ("red", "green", "blue"):
        check(own[name] == again.get(name), "meshlab.ply: %s is not what it was" % name)
    check(len(set(zip(own["red"], own["green"], own["blue"]))) > 100, "box.ply: of few colours")


def check_off(file, log, count):
    """`count` comparisons in a log, all within rounding."""
    off = re.findall(r"^(.*): off by (\S+)$", log, re.M)
    check(len(off) == count, "%s: compares %s" % (file, [name for name, _ in off]))
    for name, difference in off:
        check(float(difference) <= 1e-9, "%s: %s is off by %s" % (file, name, difference))


def check_relight():
    """What the plugin adds up is the sum of what relight computes for each light, to rounding: each is the same system
    solved for the same right-hand side, but for a factor. The picture is exposed a stop brighter."""
    log = open("relight.log").read()
    check("groups: ['lamp']" in log, "relight.log: other light groups than the lamp")
    check("all off: at most 0\n" in log, "relight.log: light remains")
    check_off("relight.log", log, 7)
    brighter = float(re.search(r"^display_rgb: brighter by (\S+) to (\S+)$", log, re.M).group(1))
    check(brighter >= 0.0, "relight.log: a stop more makes display_rgb darker")
    check(len(Picture("relight.png").colours()) > 100, "relight.png: of few colours")


def check_relight_again():
    """The groups of a file that has changed take the place of those it had, and the light adds up as for the first."""
    log = open("again.log").read()
    check("first: ['lamp']\n" in log, "again.log: other light groups than the lamp at first")
    check("then: ['sky']\n" in log, "again.log: other light groups than the sky then")
    check_off("again.log", log, 2)


os.chdir(sys.argv[1])
parts = [check_box, check_luminance, check_macro, check_relight, check_relight_again, check_courtyard, check_basis,
         check_error, check_meshlab]
for part in parts:
    before = len(failures)
    part()
    print("%s %s" % ("FAILED" if len(failures) > before else "passed", part.__name__[6:]))
for failure in failures[:20]:
    print(failure, file=sys.stderr)
sys.exit(1 if failures else 0)
