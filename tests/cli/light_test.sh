# What shines: the sky where nothing else does, lamps where there are any; one channel where all is grey.
. "$(dirname "$0")/lib.sh"

report() { # report MESH OPTION...
    local mesh=$1
    shift
    expect_exit 0 "$bake" "$mesh" out.ply $small --report report.json "$@"
}

report "$DIFUSA_DATA/bowl.ply"
expect_text stdout "note: nothing emits light: a uniform sky of irradiance 1 W/m^2 is assumed (--sky)"
expect_text report.json "nothing emits light"
[ "$(entry report.json channels)" = 1 ] || fail "a grey scene has $(entry report.json channels) channels"
[ "$(grep -c 'nothing emits' stdout)" = 1 ] || fail "a note is repeated"

report "$DIFUSA_DATA/bowl.ply" --sky 2
expect_no_text stdout "nothing emits"
[ "$(entry report.json channels)" = 1 ] || fail "a grey sky needs one channel"
report "$DIFUSA_DATA/bowl.ply" --sky 1,2,3
[ "$(entry report.json channels)" = 3 ] || fail "a coloured sky needs three channels"

report "$box"
expect_no_text stdout "nothing emits"
[ "$(entry report.json channels)" = 3 ] || fail "a coloured box needs three channels"
[ "$(entry report.json area_light_triangles)" = 2 ] || fail "the lamp was not found"

printf 'OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n' >square.off
report square.off --reflectance 0.25
expect_text stdout "faces without a colour have the reflectance 0.25,0.25,0.25 (--reflectance)"
report square.off --reflectance 0.25,0.5,0.75
[ "$(entry report.json channels)" = 3 ] || fail "a coloured reflectance needs three channels"
# An unshaded square under a sky of irradiance 1 absorbs 1 - rho of it: 0.75 + 0.5 + 0.25 W.
sed -n '/"absorbed"/,/]/p' report.json | tr -d ' ,\n' >absorbed
grep -Eq '0\.75[0-9]*0\.5[0-9]*0\.25' absorbed || grep -Eq '0\.7[45][0-9]*0\.(5|49)[0-9]*0\.2[45]' absorbed ||
    fail "absorbed: $(cat absorbed)"
