# form_factors writes the matrix of view factors of a mesh in three formats, and refuses what is wrong before the work.
. "$(dirname "$0")/lib.sh"
factors=$DIFUSA_BIN/form_factors

refuse() { # refuse CODE TEXT ARGUMENT...
    local code=$1 text=$2
    shift 2
    expect_refusal "$code" "$text" "$factors" "$@"
}

# A unit cube seen from inside, six squares: two tenths to each other side.
closed_cube >cube.off

# What is repaired in a mesh is said, whether or not the factors can be computed from it.
expect_exit 0 "$factors" "$DIFUSA_DATA/ugly.off" ugly.csv --tolerance 1e-3
expect_text stderr "note: repaired: "
expect_no_text stderr "noticed: "
expect_exit 0 "$factors" "$DIFUSA_DATA/ugly.off" ugly.csv --tolerance 1e-3 --quiet
[ ! -s stderr ] || fail "--quiet says something: $(cat stderr)"
expect_exit 2 "$factors" "$DIFUSA_DATA/ugly.off" ugly.npz --tolerance 1e-3 --close
expect_text stderr "note: repaired: " "closure can only be enforced"

# Nothing sees anything: empty arrays have checksums, too.
printf 'OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n' >plate.off
expect_exit 0 "$factors" plate.off plate.npz
expect_text stdout "surfaces: 1 (1 triangle), 0 form factors above 0" "row sums: 0 to 0 ("
if command -v python3 >/dev/null; then
    python3 -c 'import zipfile; assert zipfile.ZipFile("plate.npz").testzip() is None' || fail "a damaged plate.npz"
fi

# Overlapping faces: two on the same side of an edge, one on the other, under a ceiling.
cat >overlap.off <<'END'
OFF
9 4 0
0 0 0
1 0 0
0.5 1 0
0.3 0.8 0
0.5 -1 0
-1 -1 1
2 -1 1
2 2 1
-1 2 1
3 0 1 2
3 0 1 3
3 1 0 4
4 5 8 7 6
END
expect_exit 0 "$factors" overlap.off overlap.csv --tolerance 1e-4

# Wrong command lines.
refuse 1 "a mesh file is expected"
refuse 1 "an output file is expected" cube.off
refuse 1 "\`third\` is one argument too many" cube.off out.csv third
refuse 1 "unknown option --tolerence, did you mean --tolerance?" cube.off out.csv --tolerence 1
refuse 1 "must be a positive number" cube.off out.csv --tolerance 0
refuse 1 "--surfaces wall: must be one of face, material, group" cube.off out.csv --surfaces wall
refuse 1 "--layout full: must be one of sparse, dense, grouped" cube.off out.csv --layout full
refuse 1 "--layout grouped: is for the triangles of the mesh" cube.off out.npz --layout grouped --close
refuse 1 "the name must end in .npz" cube.off out.csv --layout grouped
refuse 1 "--method magic: must be one of exact, rays" cube.off out.csv --method magic
refuse 1 "belong to --method rays" cube.off out.csv --rays 100
refuse 1 "--seed belong to --method rays" cube.off out.csv --seed 0
refuse 1 "--points 1: must be at least 2: errors are estimated" cube.off out.csv --method rays --points 1
refuse 1 "--points 0: must be a whole number" cube.off out.csv --method rays --points 0
refuse 1 "--tolerance belongs to --method exact" cube.off out.csv --method rays --tolerance 1e-3
refuse 1 "the name must end in .csv" cube.off out.txt
refuse 1 "must be at most 1024" cube.off out.csv --threads 1025
refuse 2 "no-such.off" no-such.off out.csv
refuse 4 "no-such-directory" cube.off no-such-directory/out.csv
printf 'OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n' >open.off
refuse 2 "closure can only be enforced on a closed surface" open.off out.csv --close
refuse 2 'the form factors of surface "default" sum to 0' open.off out.csv --close --surfaces material

# The sides of a cube, in all formats and layouts.
expect_exit 0 "$factors" cube.off cube.csv
expect_text stdout "surfaces: 6 (12 triangles), 30 form factors above 0" "row sums: 1 " "reciprocity" "escapes" \
    "above the tolerance of 1e-06: 0" "written: cube.csv" "0.19982490" "0.20004378"
[ "$(head -n 1 cube.csv)" = "from,to,form_factor,error" ] || fail "no header"
[ "$(wc -l <cube.csv)" = 37 ] || fail "30 form factors, 6 escapes and a header are expected"
grep -qE '^"0","1",0\.19982489' cube.csv || fail "wrong factor between opposite sides"
grep -qE '^"0","2",0\.20004377' cube.csv || fail "wrong factor between neighbours"
expect_exit 0 "$factors" cube.off dense.csv --layout dense --quiet
[ ! -s stdout ] && [ ! -s stderr ] || fail "--quiet says something"
[ "$(head -n 1 dense.csv)" = 'surface,area,"0","1","2","3","4","5",row_sum,escapes' ] || fail "no dense header"
[ "$(wc -l <dense.csv)" = 7 ] || fail "six rows are expected"
expect_exit 0 "$factors" cube.off cube.mtx
[ "$(head -n 1 cube.mtx)" = "%%MatrixMarket matrix coordinate real general" ] || fail "no Matrix Market header"
[ "$(sed -n 2p cube.mtx)" = "6 6 30" ] || fail "wrong size"
expect_exit 0 "$factors" cube.off dense.mtx --layout dense
[ "$(wc -l <dense.mtx)" = 38 ] || fail "36 numbers are expected"
for layout in sparse dense; do
    expect_exit 0 "$factors" cube.off cube.npz --layout $layout
    if command -v python3 >/dev/null; then
        python3 - $layout <<'PYTHON' || fail "the $layout .npz file is not what it should be"
import ast, struct, sys, zipfile
archive = zipfile.ZipFile("cube.npz")
assert archive.testzip() is None
def array(name):
    data = archive.read(name + ".npy")
    assert data[:8] == b"\x93NUMPY\x01\x00" and (10 + struct.unpack("<H", data[8:10])[0]) % 64 == 0
    start = 10 + struct.unpack("<H", data[8:10])[0]
    header = ast.literal_eval(data[10:start].decode())
    assert not header["fortran_order"]
    kind, body = header["descr"], data[start:]
    if kind[1] == "S":
        return header["shape"], [body[k:k + int(kind[2:])] for k in range(0, len(body), int(kind[2:]))]
    code = {"<f8": "d", "<f4": "f", "<i4": "i", "<i8": "q"}[kind]
    return header["shape"], struct.unpack("<%d%s" % (len(body) // struct.calcsize(code), code), body)
assert array("area")[0] == (6,) and all(abs(A - 1) < 1e-15 for A in array("area")[1])
assert all(abs(sum_ - 1) < 1e-8 for sum_ in array("row_sum")[1])
assert array("names") == ((6,), [b"0", b"1", b"2", b"3", b"4", b"5"])
if sys.argv[1] == "dense":
    shape, F = array("form_factors")
    assert shape == (6, 6) and abs(F[1] - 0.199824895698387) < 1e-8 and F[0] == 0
else:
    assert array("format") == ((), [b"csr"]) and array("shape")[1] == (6, 6)
    assert array("indptr")[1] == (0, 5, 10, 15, 20, 25, 30) and array("indices")[1][:5] == (1, 2, 3, 4, 5)
    assert abs(array("data")[1][0] - 0.199824895698387) < 1e-8 and len(array("error")[1]) == 30
PYTHON
    fi
done

# Links between groups of triangles, from which the row sums follow.
expect_exit 0 "$factors" cube.off grouped.npz --layout grouped --tolerance 1e-4
expect_text stdout "triangles: 12, in 23 groups with " " links" "row sums: 1 " "written: grouped.npz"
if command -v python3 >/dev/null; then
    python3 - <<'PYTHON' || fail "the file of groups is not what it should be"
import ast, struct, zipfile
archive = zipfile.ZipFile("grouped.npz")
def array(name):
    data = archive.read(name + ".npy")
    start = 10 + struct.unpack("<H", data[8:10])[0]
    header, body = ast.literal_eval(data[10:start].decode()), data[start:]
    code = {"<f8": "d", "<f4": "f", "<i4": "i"}[header["descr"]]
    numbers = struct.unpack("<%d%s" % (len(body) // struct.calcsize(code), code), body)
    columns = header["shape"][1] if len(header["shape"]) > 1 else 0
    return [numbers[k:k + columns] for k in range(0, len(numbers), columns)] if columns else numbers
order, first, last, area, centroid = (array(n) for n in ("order", "group_first", "group_last", "area", "centroid"))
members = lambda g: [order[k] for k in range(first[g], last[g])]
at = lambda g, slope, t: 1 + sum(s * (c - o) for s, c, o in zip(slope, centroid[t], array("group_centroid")[g]))
sums = [0.0] * 12
for a, b, k, slope_a, slope_b in zip(*(array(n) for n in ("link_a", "link_b", "kernel", "gradient_a", "gradient_b"))):
    for i in members(a):
        for j in members(b):
            kernel = k * at(a, slope_a, i) * at(b, slope_b, j)
            sums[i] += area[j] * kernel
            sums[j] += area[i] * kernel
assert all(abs(s - r) < 1e-12 and abs(s - 1) < 1e-4 for s, r in zip(sums, array("row_sum")))
assert all(abs(r + e - 1) < 1e-15 for r, e in zip(array("row_sum"), array("escapes")))
assert array("surface") == tuple(t // 2 for t in range(12)) and len(array("error")) == len(array("kernel"))
PYTHON
fi

# Materials that no library defines are surfaces all the same.
grep -v mtllib "$box" >names.obj
expect_exit 0 "$factors" names.obj names.csv --surfaces material --layout dense --tolerance 1e-2
expect_text stdout "surfaces: 4 (38 triangles)" white red green lamp

# Materials of a room, closed by least squares; the same bits for any number of threads.
expect_exit 0 "$factors" "$box" one.csv --surfaces material --layout dense --tolerance 1e-2 --threads 1
expect_exit 0 "$factors" "$box" three.csv --surfaces material --layout dense --tolerance 1e-2 --threads 3
cmp one.csv three.csv || fail "the result depends on the number of threads"
expect_exit 0 "$factors" cube.off closed.csv --close
expect_text stdout "closure: form factors changed by at most" "row sums are 1 within"
expect_no_text stdout "-0.00000000"
expect_exit 0 "$factors" "$DIFUSA_DATA/furnace_box.obj" factors.npz --tolerance 1e-8 --close
expect_no_text stdout "-0.00000000"

# Counted by rays.
expect_exit 0 "$factors" cube.off rays.csv --method rays --rays 256 --points 8 --layout dense
expect_text stdout "0.19" "0.20"
expect_exit 0 "$factors" cube.off again.csv --method rays --rays 256 --points 8 --layout dense --threads 3
cmp rays.csv again.csv || fail "the rays depend on the number of threads"
expect_exit 0 "$factors" cube.off other.csv --method rays --rays 256 --points 8 --layout dense --seed 1
cmp -s rays.csv other.csv && fail "another seed makes no difference"

# The examples of --help with a scene of the data.
expect_exit 0 "$factors" "$DIFUSA_DATA/oven.json" factors.csv --surfaces material --thermal heat.csv --tolerance 1e-3
expect_text stdout "written: heat.csv"

# Help and version.
expect_exit 0 "$factors" --help
expect_text stdout "--tolerance" "--surfaces" "--close" "Examples" "oven.json" "2 input (with --close also an open surface)"
expect_exit 0 "$factors" --version
expect_text stdout "form_factors "
