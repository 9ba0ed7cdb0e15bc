# The same input, options and seed give the same bits, for any number of threads and whatever format the mesh is in.
. "$(dirname "$0")/lib.sh"

output="" # as fine as it comes
if [ $sanitized = yes ]; then
    output="--output-spacing 0.3"
fi

field() { # field OUTPUT MESH OPTION...
    local out=$1 mesh=$2
    shift 2
    expect_exit 0 "$bake" "$mesh" "$out" --sites 150 --rays 32 $output --quiet "$@"
}

for choice in "" "--adaptive" "--adaptive --basis patch-constant" "--visibility embree" "--basis radial --sampler view-driven" "--transport pairwise --sky 1"; do
    field one.ply "$box" --threads 1 --sites-output one_sites.ply $choice
    for threads in 2 5; do
        field many.ply "$box" --threads $threads --sites-output many_sites.ply $choice
        expect_same_field one.ply many.ply
        expect_same_field one_sites.ply many_sites.ply
    done
done
if "$bake" --list-plugins | grep -q '^  embree '; then
    field one.ply "$box" --visibility embree
    field other.ply "$box" --visibility cgal
    expect_same_field one.ply other.ply
fi
field one.ply "$box" --seed 7
field again.ply "$box" --seed 7
field other.ply "$box" --seed 8
expect_same_field one.ply again.ply
expect_other_field one.ply other.ply

# One mesh in four formats. Its coordinates are floats, so that STL keeps them too.
cat >mesh.off <<'MESH'
OFF
5 4 0
0 0 0
1 0 0
1 1 0
0 1 0
0.5 0.5 0.75
3 0 1 4
3 1 2 4
3 2 3 4
3 3 0 4
MESH
cat >mesh.obj <<'MESH'
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 0.5 0.5 0.75
f 1 2 5
f 2 3 5
f 3 4 5
f 4 1 5
MESH
cat >mesh.ply <<'MESH'
ply
format ascii 1.0
element vertex 5
property double x
property double y
property double z
element face 4
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
1 1 0
0 1 0
0.5 0.5 0.75
3 0 1 4
3 1 2 4
3 2 3 4
3 3 0 4
MESH
{
    echo "solid mesh"
    for triangle in "0 0 0/1 0 0" "1 0 0/1 1 0" "1 1 0/0 1 0" "0 1 0/0 0 0"; do
        printf 'facet normal 0 0 0\nouter loop\nvertex %s\nvertex %s\nvertex 0.5 0.5 0.75\nendloop\nendfacet\n' \
            "${triangle%/*}" "${triangle#*/}"
    done
    echo "endsolid mesh"
} >mesh.stl
for format in off obj ply stl; do
    field "of_$format.ply" mesh.$format
done
expect_same_field of_off.ply of_obj.ply
expect_same_field of_off.ply of_ply.ply
expect_same_field of_off.ply of_stl.ply # its points come in another order, and are merged
