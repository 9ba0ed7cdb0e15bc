# One scene in three formats, with lamps, a point light, a sun and a sheet that shines on both sides: the same fields.
. "$(dirname "$0")/lib.sh"

scenes=$DIFUSA_DATA/../tests/scenes
for name in same_obj.json same_off.json same.gltf; do
    expect_exit 0 "$bake" "$scenes/$name" "$name.vtp" $small --quiet
done
for name in same_off.json same.gltf; do
    expect_exit 0 "$DIFUSA_BIN/compare_fields" "$name.vtp" same_obj.json.vtp --report "$name.txt"
    expect_text "$name.txt" '"same_mesh": true'
    [ "$(entry "$name.txt" error)" = 0.0 ] || fail "$name is not the same: $(entry "$name.txt" error)"
done
