#!/usr/bin/env python3
"""Exact form factors (--analytic) against rays alone, in open scenes whose indirect light is known.

    tests/bench/open_scenes.py BIN_DIR [OPTIONS]...

Each OPTIONS is one argument with further options of a bake, such as "--rays 2048"; "" stands for the defaults. Prints
the root mean square error of the indirect irradiance, relative to its rms, at random points where it is known, and the
processor time of the bake without its error estimate:

wall     a black wall beside a floor of 4 by 4 m under an overhead sun: all of the floor in sight, in closed form
box      the same with a black box on the floor, which hides a part of it, seen from above its top
crater   a spherical bowl of half-angle 40 degrees, reflectance 0.3, under a sun at 15 degrees: the shaded part, which
         receives the same from everywhere (Ingersoll, Svitek and Murray, Icarus 100, 1992), for facets of three sizes
"""
import csv
import math
import pathlib
import random
import resource
import shlex
import subprocess
import sys
import tempfile

HALF_ANGLE, ELEVATION, REFLECTANCE = math.radians(40), math.radians(15), 0.3


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def form_factor(x, normal, polygon):
    """Lambert's formula for a polygon above the horizon of x."""
    total = 0.0
    for p, q in zip(polygon, polygon[1:] + polygon[:1]):
        u, v = [a - b for a, b in zip(p, x)], [a - b for a, b in zip(q, x)]
        side = cross(u, v)
        length = math.sqrt(dot(side, side))
        if length > 0.0:
            total += math.atan2(length, dot(u, v)) * dot(normal, side) / length
    return abs(total) / (2 * math.pi)


def hull(points):
    """Andrew's monotone chain."""
    def half(ordered):
        chain = []
        for p in ordered:
            while len(chain) > 1 and ((chain[-1][0] - chain[-2][0]) * (p[1] - chain[-2][1])
                                      <= (chain[-1][1] - chain[-2][1]) * (p[0] - chain[-2][0])):
                chain.pop()
            chain.append(p)
        return chain[:-1]
    ordered = sorted(set(points))
    return half(ordered) + half(ordered[::-1])


def cut(polygon, a, b, c):
    """The part where a x + b y + c >= 0."""
    kept = []
    for p, q in zip(polygon, polygon[1:] + polygon[:1]):
        at_p, at_q = a * p[0] + b * p[1] + c, a * q[0] + b * q[1] + c
        if at_p >= 0:
            kept.append(p)
        if at_p * at_q < 0:
            t = at_p / (at_p - at_q)
            kept.append((p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])))
    return kept


FLOOR = [(0, -2, 0), (4, -2, 0), (4, 2, 0), (0, 2, 0)]
BOX = ((1, 2), (-0.5, 0.5), (0, 1))


def wall_irradiance(x, with_box):
    """Of a wall in x = 0, from a floor of radiosity 0.5, less what the box hides of it as projected onto it."""
    factor = form_factor(x, (1, 0, 0), FLOOR)
    if with_box:
        corners = [(a, b, c) for a in BOX[0] for b in BOX[1] for c in BOX[2]]
        t = [x[2] / (x[2] - c) for _, _, c in corners]
        shadow = hull([(s * a, x[1] + s * (b - x[1])) for s, (a, b, _) in zip(t, corners)])
        for side in ((-1, 0, 4), (0, 1, 2), (0, -1, 2)):
            shadow = cut(shadow, *side)
        if len(shadow) > 2:
            factor -= form_factor(x, (1, 0, 0), [(a, b, 0) for a, b in shadow])
    return 0.5 * factor


def write_wall(folder, with_box):
    faces = [("floor", FLOOR), ("black", [(0, -2, 0), (0, 2, 0), (0, 2, 3), (0, -2, 3)])]
    if with_box:
        (x0, x1), (y0, y1), (_, z) = BOX
        faces += [("black", [(x0, y0, z), (x1, y0, z), (x1, y1, z), (x0, y1, z)]),
                  ("black", [(x0, y1, z), (x0, y1, 0), (x0, y0, 0), (x0, y0, z)]),
                  ("black", [(x1, y0, 0), (x1, y1, 0), (x1, y1, z), (x1, y0, z)]),
                  ("black", [(x0, y0, 0), (x1, y0, 0), (x1, y0, z), (x0, y0, z)]),
                  ("black", [(x1, y1, 0), (x0, y1, 0), (x0, y1, z), (x1, y1, z)])]
    (folder / "wall.mtl").write_text("newmtl floor\nKd .5 .5 .5\nnewmtl black\nKd 0 0 0\n")
    lines = ["mtllib wall.mtl"]
    for number, (material, corners) in enumerate(faces):
        lines += ["v %r %r %r" % tuple(map(float, p)) for p in corners]
        lines += [f"usemtl {material}", "f " + " ".join(str(4 * number + k) for k in range(1, 5))]
    (folder / "wall.obj").write_text("\n".join(lines) + "\n")
    return folder / "wall.obj"


def write_crater(folder, rings):
    """Rings of trapezoids around a fan; its triangles."""
    around = 4 * rings
    points = [(0.0, 0.0, -1.0)]
    for ring in range(1, rings + 1):
        b = HALF_ANGLE * ring / rings
        for k in range(around):
            a = 2 * math.pi * k / around
            points.append((math.sin(b) * math.cos(a), math.sin(b) * math.sin(a), -math.cos(b)))
    faces = [(0, 1 + k, 1 + (k + 1) % around) for k in range(around)]
    for ring in range(rings - 1):
        first = 1 + ring * around
        for k in range(around):
            p, q = first + k, first + (k + 1) % around
            faces += [(p, p + around, q + around), (p, q + around, q)]
    with open(folder / "crater.off", "w") as file:
        file.write("OFF\n%d %d 0\n" % (len(points), len(faces)))
        file.writelines("%r %r %r\n" % p for p in points)
        file.writelines("3 %d %d %d\n" % t for t in faces)
    return folder / "crater.off", [tuple(points[i] for i in t) for t in faces]


def shaded_points(triangles, count):
    """In shade, away from its edge, by area."""
    sun = (math.cos(ELEVATION), 0.0, math.sin(ELEVATION))
    areas = []
    for a, b, c in triangles:
        n = cross([x - y for x, y in zip(b, a)], [x - y for x, y in zip(c, a)])
        areas.append(math.sqrt(dot(n, n)))
    found = []
    while len(found) < count:
        a, b, c = random.choices(triangles, areas)[0]
        u, v = random.random(), random.random()
        u, v = (1 - u, 1 - v) if u + v > 1 else (u, v)
        p = tuple(x + u * (y - x) + v * (z - x) for x, y, z in zip(a, b, c))
        q = [x / math.sqrt(dot(p, p)) for x in p]
        facing = -dot(q, sun)
        if facing <= 0 or q[2] + 2 * facing * sun[2] < -math.cos(HALF_ANGLE) - 0.03:
            found.append(p)
    return found


def bake(program, scene, points, options, folder):
    (folder / "points.txt").write_text("".join("%r,%r,%r\n" % p for p in points))
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([program, scene, folder / "out.vtp", "--at", folder / "points.txt", "--at-output",
                    folder / "points.csv", "--error-points", "0", "--quiet", *options], check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    with open(folder / "points.csv") as lines:
        rows = [float(row["irradiance_indirect_R"]) for row in csv.DictReader(lines)]
    return rows, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    program = pathlib.Path(sys.argv[1]) / "bake_radiosity"
    random.seed(1)
    share = (1 - math.cos(HALF_ANGLE)) / 2
    crater = REFLECTANCE * share * (1 - share) * math.sin(ELEVATION) / (1 - REFLECTANCE * share)
    print("| scene | options | error | processor time, s |\n|---|---|---|---|")
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        cases = []
        for name, low in (("wall", 0.05), ("box", 1.05)):
            points = [(0.0, random.uniform(-1.9, 1.9), random.uniform(low, 2.95)) for _ in range(800)]
            cases.append((name, lambda name=name: write_wall(folder, name == "box"), points,
                          [wall_irradiance(p, name == "box") for p in points], ["--sun", "0,0,1,1"]))
        for rings in (28, 56, 112):
            scene, triangles = write_crater(folder, rings)
            points = shaded_points(triangles, 1000)
            light = ["--reflectance", str(REFLECTANCE), "--sites", "9600", "--rays", "1024", "--sun",
                     "%r,0,%r,1" % (math.cos(ELEVATION), math.sin(ELEVATION))]
            cases.append((f"crater, {len(triangles)} facets", lambda rings=rings: write_crater(folder, rings)[0], points,
                          [crater] * len(points), light))
        for name, write, points, exact, light in cases:
            scene = write()
            for options in sys.argv[2:] or [""]:
                found, took = bake(program, scene, points, light + shlex.split(options), folder)
                error = math.sqrt(sum((a - b) ** 2 for a, b in zip(found, exact)) / sum(b * b for b in exact))
                print(f"| {name} | {options.strip() or 'defaults'} | {error:.1e} | {took:.2f} |", flush=True)


if __name__ == "__main__":
    main()
