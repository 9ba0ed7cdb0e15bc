#include "scenes.h"

namespace scenes {

std::string ugly_off() {
    return R"(OFF
# A mesh that is ugly on purpose. It bakes, with a warning for each kind of fault.
# Written by hand in data/generator/ugly.cpp. Lengths in metres, z is up.
26 20 0

# A floor, L-shaped.
0 0 0
4 0 0
4 2 0
2 2 0
2 4 0
0 4 0
# Two walls on it; the last corner of the second is out of its plane.
0 0 2
4 0 2
0 4 2.0
0.2 0 2
# The first wall's corners again, for the face that uses them: points that lie at one place.
0 0 0
4 0 0
# A box over the floor, on which it stands by one corner only.
1 1 0
1.5 1 0.3
1.5 1.5 0.6
1 1.5 0.3
0.8 0.8 0.8
1.3 0.8 1.1
1.3 1.3 1.4
0.8 1.3 1.1
# A sheet, and a fin that makes an edge of three faces with it.
3 0.5 1
3.5 0.5 1
3.5 1 1
3 1 1
# No face uses this one.
9 9 9
# Half-way between two corners of the sheet.
3.25 0.5 1

6  0 1 2 3 4 5        180 170 150   # concave
4  0 6 7 1            170  90  50   # the first wall
4  0 5 8 9            170  90  50   # the second wall, neither plane nor meeting the first
4  0 6 7 1            170  90  50   # the first wall once more
4  10 11 7 6          170  90  50   # and from behind: a sheet with two sides
3  3 3 4              200 200 200   # two corners are one: an edge
5  12 13 13 14 15     200 200 200   # a corner repeated: a square none the less
4  12 16 17 13        200 200 200
4  13 17 18 14        200 200 200
4  14 15 19 18        200 200 200   # turned over
4  15 19 16 12        200 200 200
4  16 19 18 17        200 200 200
4  20 21 22 23         60 120 180   # the sheet
4  20 23 22 21         60 120 180   # its other side
3  20 21 7             60 120 180   # the fin
3  1 0 11             200 200 200   # two of its corners lie at one place
3  20 25 21            60 120 180   # all on one line
3  0 1 7              200 200 200   # covers half of the first wall
3  2 3 18             200 200 200
3  2 4 3              200 200 200   # lies in the floor's corner, across it
)";
}

} // namespace scenes
