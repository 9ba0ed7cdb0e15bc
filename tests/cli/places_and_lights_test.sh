# The light at places of a list, at the centres of faces, of point lights, and of each light apart.
. "$(dirname "$0")/lib.sh"

printf 'OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n' >square.off
printf 'x,y,z\n0.5,0.2,0\n0.3,0.9,1\n' >places.csv # not on the diagonal, where rays start a little beside

# Wrong command lines.
refuse() { # refuse CODE TEXT ARGUMENT...
    local code=$1 text=$2
    shift 2
    expect_refusal "$code" "$text" "$bake" square.off out.ply "$@"
}
refuse 1 "--at places.csv: the results need an output file, --at-output FILE.csv" --at places.csv
refuse 1 "--at-output light.csv: no points were given; name a file of points, --at FILE" --at-output light.csv
refuse 1 "would overwrite the list of points" --at places.csv --at-output ./places.csv
refuse 1 "two outputs have this name" --at places.csv --at-output light.csv --report light.csv
printf '1,5,,0\n' >empty_field.csv
refuse 2 "empty_field.csv:1: field 3 is empty" --at empty_field.csv --at-output light.csv
refuse 2 "no-such.csv" --at no-such.csv --at-output light.csv
refuse 4 "no-such-directory" --at places.csv --at-output no-such-directory/light.csv
refuse 1 "did you mean --point-light?" --point-ligth 0,0,1,1
for bad in 0,0,1 0,0,1,-1 0,0,1,1,1 up 0,0,nan,1; do
    refuse 1 "--point-light $bad: takes X,Y,Z,R or X,Y,Z,R,G,B" "--point-light=$bad"
done

# A point light of I W/sr at the height h over a flat floor: H = I h / r^3, exactly, and nothing else shines.
expect_exit 0 "$bake" square.off out.vtp $small --reflectance 0.5 --point-light 0.5,0.5,2,8,4,2 --face-centres \
    --at places.csv --at-output light.csv
expect_text stdout "written: light.csv"
expect_no_text stdout "uniform sky"
[ "$(wc -l <light.csv)" = 3 ] || fail "two places and a heading were expected"
# The number of a column.
column() { head -n 1 light.csv | tr ',' '\n' | grep -n -i -x "$1" | cut -d: -f1; }
awk -F, -v n="$(column irradiance_R)" 'NR > 1 { r = sqrt(4 + ($1 - 0.5)^2 + ($2 - 0.5)^2); want = 8 * 2 / r^3
    if (!(($n - want)^2 < (1e-12 * want)^2)) { print "irradiance", $n, "not", want; exit 1 } }' light.csv ||
    fail "the light at the places is not that of the point light"
sed -n '/<CellData/,/<\/CellData/p' out.vtp >cells
expect_text cells 'Name="radiosity"' 'Name="irradiance"' 'Name="original_face_id"'

# Sensors in mid-air: a sphere gathers I / (4 r^2), to about 1 % of a lattice of planes; grids are summed up.
column_of() { head -n 1 "$1" | tr ',' '\n' | grep -n -x "$2" | cut -d: -f1; }
expect_exit 0 "$bake" square.off out.ply $small --point-light 0.5,0.5,2,8 --at places.csv --at-output sensors.csv \
    --sensor spherical --grid default:spacing=0.25,height=1 --report report.json
expect_text stdout "grid on default: 16 sensors, irradiance (W/m^2) minimum" "uniformity (minimum / mean)"
expect_text report.json '"uniformity"'
[ "$(wc -l <sensors.csv)" = 19 ] || fail "two places, 16 sensors and a heading were expected"
awk -F, -v n="$(column_of sensors.csv irradiance_direct_R)" 'NR > 1 { want = 8 / 4 / (($2 - 0.5)^2 + ($3 - 0.5)^2 + (2 - $4)^2)
    if (!(($n - want)^2 < (0.03 * want)^2)) { print "spherical irradiance", $n, "not", want; exit 1 } }' sensors.csv ||
    fail "spheres do not gather the light of the point light"
printf '0.3,0.9,1,0,0,1\n' >normal.csv
expect_exit 0 "$bake" square.off out.ply $small --point-light 0.5,0.5,2,8 --at normal.csv --at-output sensors.csv
awk -F, -v n="$(column_of sensors.csv irradiance_direct_R)" 'NR > 1 { want = 8 / (0.04 + 0.16 + 1)^1.5
    if (!(($n - want)^2 < (1e-12 * want)^2)) { print $n, "not", want; exit 1 } }' sensors.csv ||
    fail "a place with a normal is not evaluated where it stands"
expect_exit 0 "$bake" square.off out.ply $small --point-light 0.5,0.5,2,8 --at normal.csv --at-output sensors.csv --snap
expect_text stdout "counting from 0: number 0, 1 away"
expect_exit 0 "$bake" square.off out.ply $small --point-light 0.5,0.5,2,8 --at normal.csv --at-output sensors.csv --sensor spherical
expect_text stdout "the normals of 1 point of --at are ignored: a spherical sensor has none of its own"
rm sensors.csv out.ply report.json
refuse 1 "did you mean spherical?" --at places.csv --at-output light2.csv --sensor sferical
refuse 1 "--sensor horizontal: there are no sensors" --sensor horizontal
refuse 1 "--snap: there are no places" --snap
# Sensors above a sheet with two sides, in an even sky.
printf 'OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n' >sheet.off
echo '{"difusa_scene": 1, "meshes": [{"file": "sheet.off", "material": "w"}], "materials": {"w": {"double_sided": true}},
  "sky": {"type": "uniform", "irradiance": 10}}' >sheet.json
expect_exit 0 "$bake" sheet.json out.vtp --sites 100 --rays 16 --grid w:spacing=0.5,height=0.5 --at-output grid.csv
expect_text stdout "grid on w: 4 sensors, irradiance (W/m^2) minimum 10, mean 10, maximum 10,"

refuse 1 "--grid default: takes FACE:spacing=D" --grid default
refuse 1 "is none of spacing=D, height=H and margin=M" --grid default:spacing=0.1,width=3
refuse 1 "needs a spacing above 0" --grid default:height=1
refuse 1 "there is no material \`floor\`. There are: default (nor is it the number of a face)" --grid floor:spacing=0.1
# The mean over a goal is that of the floor's irradiance: over the unit square around the foot of the light it is
# 8/2 times the solid angle that the square fills, 4 atan(1 / (4 h sqrt(1/2 + h^2))), and h = 2.
cat >goals.json <<'GOALS'
{"goals": [{"name": "all", "faces": [0]}, {"name": "foot", "places": [[0.5, 0.5, 0.001]]}]}
GOALS
refuse 1 "would overwrite the file of goals" --goal goals.json --report ./goals.json
refuse 1 "--goal-samples: there are no goals" --goal-samples 64
refuse 2 "no-such.json" --goal no-such.json
expect_exit 0 "$bake" square.off out.vtp $small --reflectance 0.5 --point-light 0.5,0.5,2,8,4,2 --goal goals.json \
    --report report.json
expect_text stdout 'goal "all": mean irradiance ' 'goal "foot": mean irradiance 2, 1, 0.5 W/m^2'
awk '/"name": "all"/ { inside = 1 } inside && /"mean"/ { getline; mean = $1 + 0; want = 8 * 4 * atan2(1, 4 * 2 * sqrt(4.5))
    if (!((mean - want)^2 < (1e-3 * want)^2)) { print "mean", mean, "not", want; exit 1 } exit 0 }' report.json ||
    fail "the mean over the square is not that of the point light"

# Groups add up to all; without the option there are none.
expect_no_text out.vtp 'Name="radiosity_of_'
expect_exit 0 "$bake" "$box" out.vtp $small --sun 0,-1,0.2,3 --point-light 0,0,0,1 --light-groups
expect_text out.vtp 'Name="radiosity_of_sun"' 'Name="irradiance_of_sun"' 'Name="radiosity_of_point"'
expect_exit 0 "$bake" "$box" out.ply $small --point-light 0,0,0,1 --light-groups --at places.csv --at-output light.csv
expect_text light.csv ,radiosity_of_point_R, ,irradiance_of_point_B

# A point light all but on the surface, whose spot no surfel resolves, and one that shines away from it.
expect_exit 0 "$bake" square.off out.vtp $small --reflectance 0.5 --point-light 0.3,0.4,1e-5,1
expect_text stdout "1 point light so near the surface" "at (0.3, 0.4, 1e-05), 1e-05 from face 0"
expect_exit 0 "$bake" square.off out.vtp $small --reflectance 0.5 --point-light 0.3,0.4,1,1 --point-light=0.3,0.4,-1e-5,1
expect_no_text stdout "so near the surface"

# A spot with a beam narrower than a surfel is resolved, unless it is far narrower.
cat > spot.json <<'EOS'
{"difusa_scene": 1, "meshes": [{"file": "square.off"}], "lights": [{"type": "spot", "position": [0.3, 0.4, 1],
 "direction": [0, 0, -1], "intensity": 1000, "inner_degrees": DEGREES, "outer_degrees": DEGREES}]}
EOS
sed 's/DEGREES/0.5/g' spot.json > wide.json
sed 's/DEGREES/0.01/g' spot.json > narrow.json
expect_exit 0 "$bake" wide.json out.vtp $small --reflectance 0.5
expect_no_text stdout "beam so narrow"
expect_exit 0 "$bake" narrow.json out.vtp $small --reflectance 0.5 --point-light 0.5,0.5,2,1
expect_text stdout "1 beam so narrow" "that at (0.3, 0.4, 1), 0.000349066 wide on face 0" "give more --sites"

refuse 1 "has two values of spacing" --grid default:spacing=1,height=1,spacing=2

# A .ply has room for neither.
refuse 1 "--light-groups: a .ply cannot hold the light of each group; write out.ply as a .vtp" --light-groups
refuse 1 "--face-centres: a .ply cannot hold the light at the centres of faces; write out.ply as a .vtp" \
    --face-centres --at places.csv --at-output light2.csv
expect_refusal 1 "--face-centres: a .ply cannot hold" "$bake" square.off OUT.PLY --face-centres

# A name that XML has to be told of comes through to other programs.
cat >named.json <<'SCENE'
{"difusa_scene": 1, "meshes": [{"file": "square.off"}],
 "lights": [{"type": "point", "name": "Lamp & \"shade\" <1>", "position": [0, 0, 3], "intensity": 2}]}
SCENE
expect_exit 0 "$bake" named.json named.vtp $small --light-groups
cp named.vtp same.vtp
expect_exit 0 "$DIFUSA_BIN/compare_fields" named.vtp same.vtp --array 'irradiance_of_Lamp & "shade" <1>'
expect_text stdout 'irradiance_of_Lamp & "shade" <1>'
