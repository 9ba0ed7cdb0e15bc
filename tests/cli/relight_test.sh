# A saved transport: relit in the same light it gives the same files, in another light those of a fresh bake; and every
# way it can be refused.
. "$(dirname "$0")/lib.sh"

size="--sites 300 --rays 32 --error-points 0"
if [ $sanitized = yes ]; then
    size="--sites 80 --rays 16 --error-points 0"
fi
printf '0.3,0.001,0.3\n0.2,0.3,0.2,0,1,0\n' >places.csv
places="--at places.csv"

# In the light of the bake, with other threads: the same field, the same table.
expect_exit 0 "$bake" "$box" day.ply $size --save-transport box.difusa $places --at-output day.csv
expect_text stdout "written: box.difusa"
expect_exit 0 "$relight" box.difusa again.ply --error-points 0 $places --at-output again.csv --threads 3 --report again.json
expect_same_field day.ply again.ply
cmp day.csv again.csv || fail "the table of the relit scene differs"
expect_text stdout "transport: loaded from box.difusa" "now 0 rays" "not needed: rays from the sites, since the transport was loaded"
[ "$(entry again.json loaded_from)" = box.difusa ] || fail "the report does not name the transport"
[ "$(entry again.json first_bounce)" = live ] || [ "$(entry again.json first_bounce)" = operator ] ||
    fail "the report does not tell the first bounce"

# same_as_fresh NAME "OPTIONS OF RELIGHT" "OPTIONS OF BAKE" MESH
same_as_fresh() {
    expect_exit 0 "$relight" box.difusa relit.ply --error-points 0 $places --at-output relit.csv $2
    expect_exit 0 "$bake" "$4" fresh.ply $size --save-transport fresh.difusa $places --at-output fresh.csv $3
    expect_same_field relit.ply fresh.ply
    cmp relit.csv fresh.csv || fail "$1: the tables differ"
    if cmp -s day.csv relit.csv; then
        fail "$1: nothing has changed"
    fi
}
cp "$DIFUSA_DATA/cornell_box.obj" other.obj
sed -e 's/^Ke 0 0 0/Ke 0 0 0 /; /newmtl red/,/^Ke/s/^Ke.*/Ke 3 0.5 0.25/' "$DIFUSA_DATA/cornell_box.mtl" >cornell_box.mtl
same_as_fresh "emission of a dark material" "--emission red=3,0.5,0.25" "" other.obj
same_as_fresh "the same as a scene" "--scene other.obj" "" other.obj
sed -e '/newmtl white/,/^Ke/s/^Kd.*/Kd 0.25 0.5 0.75/' "$DIFUSA_DATA/cornell_box.mtl" >cornell_box.mtl
same_as_fresh "reflectance" "--reflectance white=0.25,0.5,0.75" "" other.obj
sed -e 's/^Ke 54.*/Ke 0 0 0/' "$DIFUSA_DATA/cornell_box.mtl" >cornell_box.mtl
sun="--sun 0.2,0.3,-1,5,4,3" sky="--sky 1,2,3" point="--point-light 0.3,0.4,0.3,1"
same_as_fresh "sun instead of the lamp" "--scale lamp=0 $sun" "$sun" other.obj
same_as_fresh "sky and point light" "--scale lamp=0 $sky $point" "$sky $point" other.obj
same_as_fresh "without the samples" "--scale lamp=0 $sun --solver jacobi" "$sun --solver jacobi" other.obj
expect_exit 0 "$relight" box.difusa groups.vtp --error-points 0 --sun 0.2,0.3,-1,5 --light-groups
expect_text groups.vtp radiosity_of_sun irradiance_of_lamp
expect_exit 0 "$relight" box.difusa operator.ply --error-points 0 --sun 0,0.05,-1,5 --first-bounce operator --report o.json
[ "$(entry o.json first_bounce)" = operator ] || fail "the first bounce is not that of the operator"

# Shadow rays are as many as in the bake, unless they are given.
expect_exit 0 "$bake" "$box" day.ply $size --shadow-rays 96 --save-transport shadows.difusa
expect_exit 0 "$relight" shadows.difusa again.ply --error-points 0 --report shadows.json
[ "$(entry shadows.json shadow_rays)" = 96 ] || fail "other shadow rays than in the bake"
expect_exit 0 "$relight" shadows.difusa again.ply --error-points 0 --shadow-rays 32 --report shadows.json
[ "$(entry shadows.json shadow_rays)" = 32 ] || fail "other shadow rays than asked for"
expect_exit 1 "$relight" shadows.difusa none.ply --shadow-rays 7
expect_text stderr "--shadow-rays 7: must be a whole number of at least 8"

# Lights that are turned off on purpose may leave darkness.
expect_exit 0 "$relight" box.difusa dark.vtp --error-points 0 --scale lamp=0 --sun 0,0,1,1
expect_text stdout "note: the lights that are left do not reach the front of any face: nothing is lit"
expect_exit 2 "$bake" other.obj none.vtp $size --sun 0,0,1,1 --sky 0
expect_exit 0 "$relight" box.difusa dark.vtp --error-points 0 --scale lamp=0
expect_text stdout "note: all lights are turned off: nothing is lit"
expect_exit 1 "$relight" box.difusa dark.vtp --error-points 0 --scale lamp=1e308
expect_text stderr "--scale lamp: the light times 1e+308 is not 0, nor from 1e-100 to 1e100"
for change in scale emission reflectance; do
    expect_exit 1 "$relight" box.difusa dark.vtp --$change lamp=0.5 --$change lamp=0.25
    expect_text stderr "--$change lamp: given twice; give one value"
done

# Without lights the bake has assumed a sky, which is a light like others: it can be scaled, and turned off.
expect_exit 0 "$bake" other.obj skylit.ply $size --save-transport skylit.difusa
expect_exit 0 "$relight" skylit.difusa dark.vtp --error-points 0 --scale sky=0
expect_text stdout "note: all lights are turned off: nothing is lit"
expect_exit 0 "$relight" skylit.difusa bright.ply --error-points 0 --scale sky=2
expect_exit 0 "$relight" skylit.difusa double.ply --error-points 0 --sky 2
expect_same_field bright.ply double.ply

# Where an accuracy was ordered, the sites and rays that reached it are saved.
expect_exit 0 "$bake" "$box" ordered.ply --error 90% --max-sites 100 --save-transport ordered.difusa
expect_exit 0 "$relight" ordered.difusa again.ply --error-points 0
expect_same_field ordered.ply again.ply

# A day: a field for each time, a series that names them, a table.
day="--sun-path 48.14,11.58,2026-06-21,120 --time-zone 2 --hours 8,16"
expect_exit 0 "$relight" box.difusa day.pvd --scale lamp=0 --north 0,0,1 $day $places --at-output path.csv
[ "$(ls day_*.vtp | wc -l)" = 5 ] || fail "there are other fields than those of five times: $(ls)"
expect_text day.pvd 'type="Collection"' 'timestep="8" part="0" file="day_0000.vtp"' 'timestep="16" part="0" file="day_0004.vtp"'
expect_text stdout "08:00" "14:00" "azimuth of the sun" "written: day.pvd (5 times, from day_0000.vtp to day_0004.vtp)" "written: path.csv"
expect_text day_0002.vtp sun_elevation radiosity
[ "$(wc -l <path.csv)" = 11 ] || fail "the table has other rows than those of two places and five times"
expect_text path.csv "hours,sun_azimuth,sun_elevation,x,y,z"
cp path.csv path.copy
expect_exit 0 "$relight" box.difusa day.pvd --scale lamp=0 --north 0,0,1 $day $places --at-output path.csv --threads 3 --quiet
cmp path.csv path.copy || fail "the table depends on the number of threads"
rm -f day.pvd day_*

# A block moved along the floor, and back: few rays are cast; saved again, the transport gives the same.
expect_exit 0 "$relight" box.difusa moved.ply --error-points 0 --move 10-14=0.05,0,-0.02,10 --save-transport moved.difusa --report moved.json
expect_text stdout "moved: 10-14 (rays from the sites: " "they cannot meet what has moved" "written: moved.difusa"
anew=$(entry moved.json rays_cast_anew) kept=$(entry moved.json rays_kept)
[ "$anew" -gt 0 ] && [ "$kept" -gt "$anew" ] || fail "$anew rays were cast anew, and $kept kept"
expect_exit 0 "$relight" moved.difusa again.ply --error-points 0 --threads 3
expect_same_field moved.ply again.ply
expect_text stdout "moved: 10-14" "now 0 rays"
matrix=1,0,0,0.05,0,1,0,0,0,0,1,-0.02,0,0,0,1
expect_exit 0 "$relight" box.difusa moved.ply --error-points 0 --move 10-14=0.05,0,-0.02
expect_exit 0 "$relight" box.difusa again.ply --error-points 0 --move 10-14=$matrix
expect_same_field moved.ply again.ply
expect_exit 0 "$relight" box.difusa moved.ply --error-points 0 --move 10-14=0,0,0
expect_exit 0 "$relight" box.difusa again.ply --error-points 0
expect_same_field moved.ply again.ply

# Refused, without a trace.
usage() { # usage TEXT ARGUMENT...
    local text=$1
    shift
    expect_refusal 1 "$text" "$relight" "$@"
}
usage "a saved transport is expected"
usage "an output file is expected" box.difusa
usage "one argument too many" box.difusa out.vtp third
usage "would overwrite the transport" box.difusa box.difusa
usage "two outputs have this name" box.difusa out.vtp --report out.vtp
usage "would overwrite the scene" box.difusa other.ply --scene other.ply
usage "unknown option --rays" box.difusa out.vtp --rays 12
usage "unknown option --error" box.difusa out.vtp --error 1%
usage "--emission lamp: takes MATERIAL=R or MATERIAL=R,G,B" box.difusa out.vtp --emission lamp
usage "--emission lamp -1: takes one number, or three" box.difusa out.vtp --emission lamp=-1
usage "did you mean lamp? There are: white, red, green, lamp" box.difusa out.vtp --emission lmap=1
usage "there is no light group \`sun\`" box.difusa out.vtp --scale sun=0
usage "the factor must be a number of at least 0" box.difusa out.vtp --scale lamp=-1
usage "did you mean live?" box.difusa out.vtp --first-bounce lve
usage "two outputs have this name" box.difusa out.vtp --report ./out.vtp
expect_refusal 1 "two outputs have this name" "$bake" "$box" out.ply $small --save-transport ./out.ply
expect_refusal 1 "would overwrite the mesh" "$bake" other.obj out.ply $small --save-transport other.obj

usage "takes OBJECT=DX,DY,DZ[,DEGREES]" box.difusa out.vtp --move lamp=1,2
usage "takes OBJECT=DX,DY,DZ[,DEGREES]" box.difusa out.vtp --move lamp=1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,2
usage "neither scales nor mirrors" box.difusa out.vtp --move lamp=2,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1
usage "--move 3-99: the faces of the file have the numbers 0 to " box.difusa out.vtp --move 3-99=0,0,0
usage "there is no object \`lmap\`, did you mean lamp?" box.difusa out.vtp --move lmap=0,0,0
usage "cannot be moved without face" box.difusa out.vtp --move 8=0,0,0.1
usage "would overwrite the transport" box.difusa out.vtp --save-transport box.difusa
usage "is written beside one lit field" box.difusa out.pvd $day --save-transport out.difusa
usage "must end in .pvd" box.difusa out.vtp $day
usage "a series needs --sun-path" box.difusa out.pvd
usage "give that, too" box.difusa out.vtp --time-zone 2
usage "omit them with --sun-path" box.difusa out.pvd $day --report report.json
usage "takes LATITUDE,LONGITUDE,YEAR-MONTH-DAY[,MINUTES]" box.difusa out.pvd --sun-path 48,11
usage "takes LATITUDE,LONGITUDE,YEAR-MONTH-DAY[,MINUTES]" box.difusa out.pvd --sun-path 48,11,2026-06-21,
usage "there is no such day" box.difusa out.pvd --sun-path 48,11,2026-02-30
usage "below the horizon" box.difusa out.pvd --sun-path 48,11,2026-06-21 --hours 0,1
expect_exit 0 "$bake" "$DIFUSA_DATA/greenhouse_row.json" row.vtp --sites 100 --rays 16 --error-points 0 --save-transport row.difusa
usage "the sun is not in symmetry plane 1 at 10 h" row.difusa out.pvd --sun-path 48.14,11.58,2026-06-21,120 --hours 10,12
usage "must not be vertical" box.difusa out.pvd --sun-path 48,11,2026-06-21 --north 0,1,0
usage "would overwrite the transport" box.difusa box.difusa.pvd --sun-path 48,11,2026-06-21 --at-output box.difusa $places

refused() { # refused TEXT FILE
    expect_refusal 2 "$1" "$relight" "$2" out.vtp
    expect_text message "bake_radiosity SCENE OUT --save-transport FILE"
}
expect_refusal 2 "cannot be opened" "$relight" nowhere.difusa out.vtp
head -c 1000 box.difusa >cut.difusa
refused "is cut short" cut.difusa
: >empty.difusa
refused "is empty" empty.difusa
refused "is not a file of the kind \`difusa transport\`" "$box"
sed -e '2s/version 6/version 5/' box.difusa >older.difusa
refused "has version 5 of its format, and this program reads version 6" older.difusa
head -c 2000 box.difusa >damaged.difusa
printf 'x' >>damaged.difusa
tail -c +2002 box.difusa >>damaged.difusa
refused "is damaged" damaged.difusa
expect_refusal 2 "is not the one that this transport was computed for" "$relight" box.difusa out.vtp --scene "$DIFUSA_DATA/bowl.ply"
expect_refusal 2 "all lights of the scene are dark" "$relight" box.difusa out.vtp --scale lamp=0 --sky 0

# The scene of a transport may be moved, and may change.
expect_exit 0 "$bake" other.obj out.ply $small --sky 1 --save-transport other.difusa
mv other.obj elsewhere.obj
expect_refusal 2 "other.obj: cannot be found; the transport was saved for this scene" "$relight" other.difusa out.vtp
expect_text message "--scene FILE"
expect_exit 0 "$relight" other.difusa relit.ply --error-points 0 --scene elsewhere.obj
sed -e 's/^usemtl red/usemtl green/' elsewhere.obj >other.obj
expect_exit 0 "$relight" other.difusa relit.ply --error-points 0
expect_text stdout "has changed since the transport was saved"

# So may the files that the scene names; and a material that no face has is no use.
mkdir -p paint
printf 'newmtl paint\nKd 0.5 0.5 0.5\nnewmtl rest\nKd 0.1 0.1 0.1\n' >paint/paint.mtl
printf 'mtllib paint.mtl\nusemtl paint\nv 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n' >paint/face.obj
printf '{"difusa_scene": 1, "meshes": [{"file": "paint/face.obj"}]}' >paint.json
expect_exit 0 "$bake" paint.json out.ply $small --sky 1 --save-transport paint.difusa
expect_exit 0 "$relight" paint.difusa relit.ply --error-points 0
expect_no_text stdout "has changed"
printf 'newmtl paint\nKd 0.7 0.7 0.7\nnewmtl rest\nKd 0.1 0.1 0.1\n' >paint/paint.mtl
expect_exit 0 "$relight" paint.difusa relit.ply --error-points 0
expect_text stdout "paint.json, or a file that it names, has changed since the transport was saved"
expect_refusal 1 "no face has the material \`rest\`" "$relight" paint.difusa out.vtp --emission rest=5

# A block on a floor without thickness does not see the sky below it, nor where it is lit again or put elsewhere.
printf 'usemtl floor\nv -4 -4 0\nv 5 -4 0\nv 5 5 0\nv -4 5 0\nf 1 2 3 4\nusemtl block\n' >block.obj
for z in 0 1; do printf 'v 0 0 %s\nv 1 0 %s\nv 1 1 %s\nv 0 1 %s\n' $z $z $z $z; done >>block.obj
printf 'f 8 7 6 5\nf 9 10 11 12\nf 5 6 10 9\nf 6 7 11 10\nf 7 8 12 11\nf 8 5 9 12\n' >>block.obj
nothing_below() {
    awk '/^goal "below"/ { dark = $5 < 1e-9 } END { exit !dark }' stdout || fail "it is light below the block"
}
printf '{"goals": [{"name": "below", "faces": [1]}]}\n' >below.json
expect_exit 0 "$bake" block.obj out.vtp $small --sky 1 --save-transport block.difusa --goal below.json
expect_text stdout "repaired: 1 face on another one in the same plane" "(face 1 (line 16) on face 0 (line 6) near"
nothing_below
expect_exit 0 "$relight" block.difusa out.vtp --sky 2 --move 1-6=0.3,0.2,0 --goal below.json
nothing_below

# Put down on the floor, it stays where it is, and a note says what that means.
sed -e 's/ 1$/ 2/; s/ 0$/ 1/; 2,5s/ 1$/ 0/' block.obj >floating.obj
expect_exit 0 "$bake" floating.obj out.vtp $small --sky 1 --save-transport floating.difusa
expect_no_text stdout "in the same plane"
expect_exit 0 "$relight" floating.difusa out.vtp --move 1-6=0,0,-1
expect_text stdout "note: moved objects lie on others in the same plane (face 1 (line 16) on face 0 (line 6) near"
