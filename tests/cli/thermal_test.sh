# Thermal scenes: both ways to solve them, their tables and files, and what is refused.
. "$(dirname "$0")/lib.sh"
factors=$DIFUSA_BIN/form_factors
view=$DIFUSA_BIN/render_view
shield=$DIFUSA_DATA/radiation_shield.json
oven=$DIFUSA_DATA/oven.json
quick="--sites 300 --rays 64"

# The polished sheet cuts the heat to 75.389 W/m²; nothing is left to chance.
expect_exit 0 "$bake" "$shield" shield.vtp --sites 1000 --rays 64 --error-points 0 --report shield.json
expect_text stdout "material  area, m^2  emissivity        given  temperature, K" "75.389" "-75.389" \
    "heat (W, positive if it leaves the surfaces)"
expect_text shield.json '"thermal": {' '"surroundings": null' '"given": "heat"' '"net_heat": 75.389'
grep -q "75.39 W/m^2" "$shield" || fail "the scene does not say what its answer is"
[ "$(grep -c 'mirror ' stdout)" -ge 1 ] || fail "no line of the mirrors"

# Fields, in every format, at the centres of faces, as sites and as pictures; errors of the irradiance.
expect_exit 0 "$bake" "$oven" oven.vtp $quick --face-centres --sites-output sites.vtp --report oven.json
expect_text stdout "error of the irradiance (rms): about" "no proven bound, since the net flux of some surface"
expect_text oven.vtp 'Name="temperature"' 'Name="net_flux"' 'Name="radiosity"' 'Name="irradiance"' 'Name="emissivity"' \
    'Name="error_estimate"' 'Name="reference_temperature"'
expect_no_text oven.vtp display_rgb
expect_text sites.vtp 'Name="temperature"'
expect_exit 0 "$bake" "$oven" oven.ply $quick
grep -aq "quality: temperature in K" oven.ply || fail "the quality is not the temperature"
expect_exit 0 "$view" "$oven" oven.png $quick --size 40 30 --samples 1 --also net-flux=flux.png --also error=error.png
expect_text stdout "oven.png" "temperature," "net-flux,"
expect_exit 0 "$DIFUSA_BIN/compare_fields" oven.vtp oven.vtp
expect_text stdout temperature
expect_no_text stdout irradiance_indirect

# At places of the surface: on the roof, on the slab, on the door.
printf '1,0.5,1\n1,0.5,0.2\n2,0.5,0.5,-1,0,0\n' >places.csv
expect_exit 0 "$bake" "$oven" oven.vtp $quick --at places.csv --at-output values.csv
head -n 1 values.csv | grep -q 'face,temperature,net_flux,radiosity,irradiance,emissivity,error_estimate$' ||
    fail "$(head -n 1 values.csv)"
awk -F, 'NR == 3 && $12 != 773.15 || NR == 4 && $13 != -1500 { exit 1 }' values.csv || fail "$(cat values.csv)"
printf '1,0.5,0.5,0,0,1\n' >sensor.csv
expect_refusal 1 "--at: $oven is a thermal scene, of which the surface alone is evaluated" "$bake" "$oven" out.vtp \
    $quick --at sensor.csv --at-output out.csv

# The same bits for any number of threads, and relit; edited temperatures need no rays.
expect_exit 0 "$bake" "$oven" one.ply $quick --threads 1
expect_exit 0 "$bake" "$oven" three.ply $quick --threads 3
expect_same_field one.ply three.ply
cp "$DIFUSA_DATA"/oven.obj "$DIFUSA_DATA"/oven.mtl .
cp "$oven" edited.json
expect_exit 0 "$bake" edited.json first.ply $quick --save-transport oven.difusa
expect_exit 0 "$relight" oven.difusa again.ply
expect_same_field first.ply again.ply
sed -i 's/"celsius": 500/"celsius": 400/' edited.json
expect_exit 0 "$relight" oven.difusa cooler.ply
expect_exit 0 "$bake" edited.json fresh.ply $quick
expect_same_field cooler.ply fresh.ply
expect_other_field cooler.ply first.ply
expect_refusal 1 "is a thermal scene, which has no lights and colours to change" "$relight" oven.difusa out.ply \
    --emission roof=5

# Between surfaces: 20 kW less 1.5 kW end in the slab.
expect_exit 0 "$factors" "$oven" ff.csv --surfaces material --thermal heat.csv --tolerance 1e-4 --close
expect_text stdout "net flux, W/m^2" "errors of the form factors change net fluxes by at most"
expect_text heat.csv '"roof","roof",heat,2,0.9,' '"(surroundings)",,temperature'
awk -F, '$1 ~ /slab/ { if ($8 < -18500.001 || $8 > -18499.999) exit 1 }' heat.csv || fail "$(cat heat.csv)"
awk -F, 'NR > 1 { sum += $8 } END { if (sum < -1e-6 || sum > 1e-6) exit 1 }' heat.csv || fail "heats do not add up"

# A shield in an open box, its back a surface of its own.
closed_cube >cube.off
cat >sheet.off <<'END'
OFF
4 1 0
0 0 0.5
1 0 0.5
1 1 0.5
0 1 0.5
4 0 1 2 3
END
cat >shielded.json <<'END'
{"difusa_scene": 1,
 "meshes": [{"file": "cube.off", "material": "side", "faces": [{"first": 0, "last": 0, "material": "hot"}]},
            {"file": "sheet.off", "material": "sheet"}],
 "materials": {"hot": {"emissivity": 0.9, "temperature": 500}, "side": {"emissivity": 0.9, "temperature": 300},
               "sheet": {"emissivity": 0.1, "heat": 0, "double_sided": true}}}
END
expect_exit 0 "$factors" shielded.json ff.csv --surfaces material --thermal heat.csv --tolerance 1e-4
expect_text heat.csv '"sheet (back)"'
awk -F, '/"sheet/ { sum += $8; t[n++] = $6 } END { if (sum > 1e-9 || sum < -1e-9 || t[0] != t[1]) exit 1 }' heat.csv ||
    fail "the sheet is not in balance: $(cat heat.csv)"
expect_exit 0 "$factors" shielded.json ff.csv --thermal heat.csv --tolerance 1e-4
expect_text heat.csv '"6b"'

# What is refused.
expect_refusal 1 "is not a thermal scene" "$factors" cube.off out.csv --thermal heat2.csv
expect_refusal 1 "the name must end in .csv (a table)" "$factors" "$oven" out.csv --thermal heat2.txt
expect_refusal 1 "two outputs have this name" "$factors" "$oven" out.csv --thermal out.csv
expect_refusal 2 "the material mirror is a mirror, over which form factors do not go" "$factors" "$shield" out.csv \
    --thermal heat2.csv --tolerance 1e-3
expect_refusal 1 "--sky, --sun, --point-light: $oven is a thermal scene" "$bake" "$oven" out.vtp --sky 1
expect_refusal 1 "of relight): $oven is a thermal scene" "$bake" "$oven" out.vtp --light-groups
expect_refusal 1 "--convergence: $oven is a thermal scene" "$bake" "$oven" out.vtp --convergence steps.pvd
expect_refusal 1 "--show luminance: a thermal scene has no light to show" "$view" "$oven" out.png --show luminance
expect_refusal 1 "--show temperature: the scene is not a thermal one" "$view" "$box" out.png --show temperature
sed 's/"side": {[^}]*}/"side": {"reflectance": 0.5}/' shielded.json >mixed.json
expect_refusal 2 "the material side has no thermal properties, but others have" "$bake" mixed.json out.vtp
sed 's/"heat": 0/"heat": -5000/' shielded.json >drawn.json
expect_refusal 2 "the material sheet would have to be colder than 0 K for its heat of -5000 W" "$bake" drawn.json \
    out.vtp $quick
sed 's/"temperature": 300/"net_flux": -2000/; s/"heat": 0/"temperature": 300/' shielded.json >drawn.json
expect_refusal 2 "more heat is drawn from the material side than arrives" "$bake" drawn.json out.vtp $quick
expect_refusal 2 "more heat is drawn from surface side" "$factors" drawn.json out.csv --surfaces material --thermal \
    heat2.csv --tolerance 1e-3

# A crate on the floor and a rug beside it, in a closed room: what they cover radiates nothing, and where all is equally
# warm, nothing exchanges heat with the surroundings, which are cold.
awk 'NR > 2 && NR < 11 { print } NR == 1 { print; print "20 13 0" }
     NR == 10 {
         for (z = 0; z <= 0.3; z += 0.3) {
             print 0.2, 0.2, z; print 0.5, 0.2, z; print 0.5, 0.6, z; print 0.2, 0.6, z
         }
         print 0.6, 0.2, 0; print 0.9, 0.2, 0; print 0.9, 0.8, 0; print 0.6, 0.8, 0
     }
     NR > 10 { print }
     END {
         print "4 8 11 10 9\n4 12 13 14 15\n4 8 9 13 12\n4 9 10 14 13\n4 10 11 15 14\n4 11 8 12 15\n4 16 17 18 19"
     }' cube.off >furnished.off
cat >furnished.json <<"END"
{"difusa_scene": 1, "meshes": [{"name": "room", "file": "furnished.off", "material": "all"}],
 "materials": {"all": {"emissivity": 0.8, "temperature": 1000}}, "surroundings": {"temperature": 300}}
END
expect_exit 0 "$factors" furnished.json ff.csv --thermal heat.csv
expect_text stderr "2 faces covered, at least in part, by others in the same plane: what is covered was left out"
# Of 6.3 m² of 45 kW/m² each, an error of 1e-6 in each of 12 factors of a row.
awk -F, '/surroundings/ { if ($8 * $8 > (6.3 * 45000 * 12e-6) ^ 2) exit 1 }' heat.csv || fail "$(cat heat.csv)"
expect_exit 0 "$bake" furnished.json furnished.ply $quick --save-transport furnished.difusa
expect_text stdout "faces covered, at least in part" "to backs and lost between mirrors 0;"
expect_no_text stdout "ends on the backs"
expect_exit 0 "$relight" furnished.difusa again.ply
expect_same_field furnished.ply again.ply
expect_refusal 1 "what they cover, which radiates nothing, was left out" "$relight" furnished.difusa out.ply \
    --move 6-11=0.1,0,0
