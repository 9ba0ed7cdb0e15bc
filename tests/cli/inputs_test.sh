# Every file that a program reads is an input, and no output replaces it: what a scene names, and what that names.
. "$(dirname "$0")/lib.sh"
render=$DIFUSA_BIN/render_view

mkdir scene
cd scene || exit 1
expect_exit 0 "$render" "$box" paint.png $small --size 8 8 --also direct=paint2.png --quiet
expect_exit 0 "$render" "$box" sky.hdr $small --size 8 8 --quiet
cp "$DIFUSA_DATA/bowl.ply" bowl.ply
cat >panel.mtl <<'MTL'
newmtl panel
Kd 0.5 0.5 0.5
map_Kd paint.png
MTL
cat >panel.obj <<'OBJ'
mtllib panel.mtl
v 0 0 5
v 1 0 5
v 0 1 5
vt 0 0
vt 1 0
vt 0 1
usemtl panel
f 1/1 2/2 3/3
OBJ
printf '\0\0\0\0\0\0\0\0\0\0\0\0\0\0\200\77\0\0\0\0\0\0\0\0\0\0\0\0\0\0\200\77\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0' >tile.bin
cat >tile.gltf <<'GLTF'
{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
 "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
 "textures": [{"source": 0}], "images": [{"uri": "paint2.png"}],
 "buffers": [{"byteLength": 36, "uri": "tile.bin"}],
 "bufferViews": [{"buffer": 0, "byteLength": 36}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}]}
GLTF
cp paint.png emission.png
cat >scene.json <<'JSON'
{"difusa_scene": 1, "unit": "m", "up": "z", "sky": {"type": "image", "file": "sky.hdr"},
 "materials": {"glow": {"reflectance": 0.5, "emission": 1, "emission_texture": "emission.png"}},
 "meshes": [{"file": "bowl.ply"}, {"file": "panel.obj"}, {"file": "tile.gltf"}]}
JSON
ln -s bowl.ply link.ply
ln panel.mtl hard.mtl
ln -s ../scene again
cd .. || exit 1
cp -r scene copy

run="scene/scene.json out.vtp $small"
expect_exit 0 "$bake" $run --report report.json
rm out.vtp report.json

# Whatever it is, and whatever its name.
for name in scene.json panel.obj panel.mtl paint.png emission.png tile.gltf tile.bin paint2.png sky.hdr hard.mtl \
    ../scene/again/tile.bin; do
    expect_refusal 1 "scene/$name: would overwrite" "$bake" $run --report "scene/$name"
done
expect_refusal 1 "scene/bowl.ply: would overwrite scene/bowl.ply, which is read" "$bake" scene/scene.json scene/bowl.ply
expect_refusal 1 "scene/link.ply: would overwrite scene/bowl.ply" "$bake" $run --sites-output scene/link.ply
expect_refusal 1 "scene/paint.png: would overwrite" "$render" scene/scene.json scene/paint.png $small
expect_refusal 1 "scene/paint2.png: would overwrite" "$render" scene/scene.json out.png $small \
    --also direct=scene/paint2.png
expect_refusal 1 "scene/bowl.ply: would overwrite" "$DIFUSA_BIN/inspect_basis" scene/scene.json scene/bowl.ply
expect_refusal 1 "scene/bowl.ply: would overwrite" "$DIFUSA_BIN/inspect_basis" scene/scene.json out.vtp \
    --sites-output scene/bowl.ply
expect_refusal 1 "scene/panel.mtl: would overwrite" "$bake" $run --dry-run --report scene/panel.mtl
[ "$(grep -cvx -e read stderr)" = 1 ] || fail "computed something before it refused"
echo "0,0,0" >points.csv
expect_refusal 1 "would overwrite the list of points" "$bake" $run --at points.csv --at-output ./points.csv
expect_refusal 1 "scene/tile.bin: would overwrite" "$bake" $run --at points.csv --at-output scene/tile.bin
diff -r scene copy || fail "an input has changed"

# A plugin is read, too.
mkdir plugins
cp "$DIFUSA_DATA/bowl.ply" plugins/mine.so
expect_refusal 1 "plugins/mine.so: would overwrite" "$bake" scene/bowl.ply out.vtp --plugin-path plugins \
    --report plugins/mine.so

# Two outputs that are one file, before there is one: a link that leads nowhere yet.
ln -s real.vtp link.vtp
expect_refusal 1 "two outputs have this name" "$bake" scene/bowl.ply real.vtp --sites-output link.vtp
