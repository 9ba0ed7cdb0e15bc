# inspect_basis shows the elements of the very basis a bake uses, and refuses what is wrong before the work.
. "$(dirname "$0")/lib.sh"
inspect=$DIFUSA_BIN/inspect_basis

refuse() { # refuse CODE TEXT ARGUMENT...
    local code=$1 text=$2
    shift 2
    expect_refusal "$code" "$text" "$inspect" "$@"
}

# Wrong command lines.
refuse 1 "a mesh file is expected"
refuse 1 "an output file is expected" "$box"
refuse 1 "\`third\` is one argument too many" "$box" basis.vtp third
refuse 1 "unknown option --elemnt, did you mean --element?" "$box" basis.vtp --elemnt 12
refuse 1 "did you mean 'shepard'?" "$box" basis.vtp --basis shepherd
refuse 1 "did you mean 'embree'?" "$box" basis.vtp --visibility embre
refuse 1 "--element -1: must be a whole number of at least 0" "$box" basis.vtp --element -1
refuse 1 "--element 1.5: must be a whole number" "$box" basis.vtp --element 1.5
for bad in 1,2 1,2,3,4 a,b,c 1,,2 nan,0,0 "1 2 3"; do
    refuse 1 "takes three numbers X,Y,Z" "$box" basis.vtp "--near=$bad"
done
refuse 1 "either --spacing or --sites" "$box" basis.vtp --spacing 0.1 --sites 10
refuse 1 "must be a positive number" "$box" basis.vtp --output-spacing 0
refuse 1 "must be at most 1024" "$box" basis.vtp --threads 1025
refuse 1 "/nowhere" "$box" basis.vtp --plugin-path . --plugin-path /nowhere
refuse 1 "basis.txt" "$box" basis.txt
refuse 2 "no-such.off" no-such.off basis.vtp
refuse 4 "no-such-directory" "$box" no-such-directory/basis.vtp
cp "$box" mesh.obj
cp "${box%.obj}.mtl" .
refuse 1 "two outputs have this name" mesh.obj basis.vtp --sites-output ./basis.vtp
mv mesh.obj mesh.ply
refuse 1 "would overwrite the mesh" mesh.ply mesh.ply
rm mesh.ply

# A number out of range is refused with the range.
few="--sites 60 --output-spacing 0.1"
expect_exit 0 "$inspect" "$box" basis.vtp $few
count=$(sed -n 's/^elements: \([0-9]*\) .*/\1/p' stdout)
[ "$count" -gt 30 ] || fail "no number of elements"
rm basis.vtp
refuse 1 "--element $count: there is no such element; they are numbered from 0 to $((count - 1))" \
    "$box" basis.vtp $few --element "$count" --quiet
expect_exit 0 "$inspect" "$box" basis.vtp $few --element "$((count - 1))" --quiet
[ ! -s stdout ] && [ ! -s stderr ] || fail "--quiet says something"

# It is the bake's basis: as many elements, at the same spacing.
expect_exit 0 "$inspect" "$box" basis.vtp $few --seed 5
grep '^elements:' stdout | sed 's/elements/sites/' >inspected
expect_exit 0 "$bake" "$box" out.vtp --sites 60 --rays 16 --seed 5
grep '^sites:' stdout >baked
cmp -s inspected baked || fail "a bake has other sites: $(cat inspected baked)"

# What is said of the elements.
expect_exit 0 "$inspect" "$box" basis.vtp $few --basis normalized-radial --element 3 --near 0,0,0 --element 3 --near=-5,0.1,1e-1 \
    --sites-output sites.vtp
expect_text basis.vtp 'Name="element"' 'Name="sum"' 'Name="overlap"' 'Name="lebesgue"' 'Name="nearest_site"' \
    'Name="Normals"' 'Name="original_face_id"'
expect_text sites.vtp 'Name="radius"' 'Name="reach"' 'Name="area"' 'Name="element"' 'Name="shown"' 'Name="Normals"'
[ "$(grep -c '^element ' stdout)" -ge 2 ] || fail "two elements are asked for at least"
[ "$(grep -c '^element 3:' stdout)" = 1 ] || fail "an element asked for twice is shown once"
expect_text stdout "sum: 1 to 1," "sum of absolute values (Lebesgue): 1 on average, at most 1" "written: sites.vtp"
expect_exit 0 "$inspect" "$box" basis.vtp $few --basis radial
expect_no_text stdout "sum: 1 to 1,"

# Samplers that cast rays, other formats, the same bits for any number of threads.
expect_exit 0 "$inspect" "$box" one.ply $few --sampler view-driven --threads 1
expect_exit 0 "$inspect" "$box" two.ply $few --sampler view-driven --threads 3
expect_same_field one.ply two.ply

expect_refusal 1 "a .ply holds a single element" "$inspect" "$box" one.ply $few --element 3 --near 0,0,0

# Help and version.
expect_exit 0 "$inspect" --help
expect_text stdout "--element" "--near" "--sites-output" "Examples"
expect_exit 0 "$inspect" --version
expect_text stdout "inspect_basis "
