# Outputs: refused names, nothing over the mesh, all files or none.
. "$(dirname "$0")/lib.sh"

expect_refusal 1 "must end in .vtp (ParaView, everything), .ply" "$bake" "$box" out.vtk
expect_refusal 1 "must end in .vtp" "$bake" "$box" out
expect_refusal 1 "must end in .vtp" "$bake" "$box" -
expect_refusal 1 "must end in .vtp" "$bake" "$box" out.vtp --sites-output sites.txt
mkdir directory.vtp
expect_refusal 1 "it is a directory" "$bake" "$box" directory.vtp
mkfifo pipe.vtp
expect_refusal 1 "device or pipe" "$bake" "$box" pipe.vtp
expect_refusal 4 "the directory \`nowhere\` does not exist" "$bake" "$box" out.vtp --report nowhere/report.json
expect_refusal 4 "the directory \`nowhere\` does not exist" "$bake" "$box" out.vtp --sites-output nowhere/sites.vtp
[ ! -d /proc ] || expect_refusal 4 "no file can be created in the directory \`/proc\`" "$bake" "$box" /proc/o.vtp
touch file
expect_refusal 4 "\`file\` is not a directory" "$bake" "$box" file/out.vtp

# The mesh, by whatever name.
cp "$DIFUSA_DATA/bowl.ply" mesh.ply
ln -s mesh.ply link.ply
ln mesh.ply hard.ply
mkdir deeper
for name in mesh.ply ./mesh.ply deeper/../mesh.ply "$PWD/mesh.ply" link.ply hard.ply; do
    expect_refusal 1 "would overwrite the mesh" "$bake" mesh.ply "$name"
    expect_refusal 1 "would overwrite the mesh" "$bake" mesh.ply out.vtp --sites-output "$name"
    expect_refusal 1 "would overwrite the mesh" "$bake" mesh.ply out.vtp --report "$name"
done
cmp mesh.ply "$DIFUSA_DATA/bowl.ply" || fail "the mesh has changed"
expect_refusal 1 "two outputs have this name" "$bake" mesh.ply out.vtp --sites-output ./out.vtp
expect_refusal 1 "two outputs have this name" "$bake" mesh.ply out.vtp --report "$PWD/out.vtp"

# All, or none: with room for one of two files neither is replaced, whichever comes first.
small_field="--sites 1500 --rays 4 --output-spacing 10 --quiet"
expect_exit 0 "$bake" "$box" small.ply $small_field --sites-output large.ply --report report.json
[ "$(stat -c %s small.ply)" -lt 32768 ] && [ "$(stat -c %s large.ply)" -gt 32768 ] || fail "sizes are not as expected"
cp small.ply small.copy
cp large.ply large.copy
cp report.json report.copy
limited() {
    (
        ulimit -f 32
        "$@"
    )
}
expect_refusal 4 "\`large.ply\`: File too large" limited "$bake" "$box" small.ply $small_field --seed 2 \
    --sites-output large.ply --report report.json
expect_refusal 4 "\`large.ply\`: File too large" limited "$bake" "$box" large.ply --sites 500 --rays 4 --quiet \
    --sites-output small.ply --report report.json
for name in small large report; do
    cmp $name.copy $name.[jp]* || fail "a failed bake has replaced one of its files"
done

# What is written has the permissions of any new file, and a link stays a link.
touch plain
[ "$(stat -c %a plain)" = "$(stat -c %a small.ply)" ] || fail "permissions of the output"
ln -s real.ply to_real.ply
expect_exit 0 "$bake" "$box" to_real.ply $small --quiet
[ -L to_real.ply ] && [ -f real.ply ] || fail "the link was replaced"

# A name that starts with a dash, spaces, capitals.
mkdir "a folder"
expect_exit 0 "$bake" "$box" "a folder/of ours.VTP" $small --quiet
expect_text "a folder/of ours.VTP" "PolyData"

# glTF holds the light groups, too, and is a mesh as large as that of the scene.
expect_exit 0 "$bake" "$box" out.glb $small --light-groups --quiet
expect_text out.glb '"COLOR_0"' '"_RADIOSITY_OF_LAMP"' '"KHR_materials_unlit"'
expect_exit 0 "$bake" out.glb again.vtp --dry-run
expect_text stdout "area 1.9207"
expect_refusal 1 "--face-centres: a .glb cannot hold" "$bake" "$box" faces.glb --face-centres
