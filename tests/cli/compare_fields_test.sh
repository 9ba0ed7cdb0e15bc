# compare_fields: from two bakes to a table, a report and an error field; everything wrong is refused.
. "$(dirname "$0")/lib.sh"

compare=$DIFUSA_BIN/compare_fields

# refused CODE TEXT ARGUMENT...
refused() {
    local code=$1 text=$2
    shift 2
    expect_refusal "$code" "$text" "$compare" "$@"
}

expect_exit 0 "$bake" "$box" coarse.vtp $small --output-spacing 0.2 --quiet
expect_exit 0 "$bake" "$box" fine.vtp --sites 250 --rays 64 --output-spacing 0.11 --quiet
expect_exit 0 "$bake" "$box" other.vtp $small --output-spacing 0.2 --seed 7 --quiet
expect_exit 0 "$bake" "$box" coarse.ply $small --output-spacing 0.2 --quiet
expect_exit 0 "$bake" "$box" fine.ply --sites 250 --rays 64 --output-spacing 0.11 --quiet --sites-output sites.vtp

# The same field: no error at all.
expect_exit 0 "$compare" coarse.vtp coarse.vtp error.vtp --report error.json
expect_text stdout "coarse.vtp against coarse.vtp: same mesh" "radiosity, W/m^2 (weighted)" \
    "radiosity_indirect, W/m^2" "L2, root mean square" "bias" "written: error.vtp" "written: error.json"
expect_text error.json '"schema": "difusa-comparison"' '"schema_version": 3' '"same_mesh": true'
[ "$(entry error.json error)" = 0.0 ] || fail "a field differs from itself: $(entry error.json error)"
expect_text stderr read compare write
for name in radiosity_error radiosity_error_absolute radiosity_error_relative radiosity_error_rgb \
    radiosity_indirect_error_relative matched distance original_face_id; do
    expect_text error.vtp "Name=\"$name\""
done

# Another seed on the same mesh; another mesh: errors, and all of the surface matched.
expect_exit 0 "$compare" other.vtp coarse.vtp --report seed.json
[ "$(entry seed.json error)" != 0.0 ] || fail "another seed makes no difference"
expect_exit 0 "$compare" coarse.vtp fine.vtp error.vtp --report fine.json --array irradiance --array reflectance
expect_text fine.json '"same_mesh": false' '"unmatched_vertices": 0' '"name": "reflectance"' '"name": "irradiance"'
expect_no_text stdout "excluded from the norms"
# The same bits for any number of threads.
expect_exit 0 "$compare" coarse.vtp fine.vtp again.vtp --report again.json --array irradiance --array reflectance \
    --threads 3
cmp error.vtp again.vtp || fail "the error field depends on the number of threads"
cmp fine.json again.json || fail "the report depends on the number of threads"
# A reference that is coarser is noted.
expect_exit 0 "$compare" fine.vtp coarse.vtp
expect_text stdout "note: the reference has fewer vertices"

# PLY has the weighted radiosity only, in floats: against the same bake in doubles the error is one of rounding, 2^-24.
expect_exit 0 "$compare" coarse.ply fine.ply error.vtp
expect_text stdout "radiosity_weighted, W/m^2" "note: the indirect light is not compared: coarse.ply has no array"
expect_exit 0 "$compare" coarse.ply coarse.vtp --report float.json
expect_text float.json '"same_mesh": true'
sed -n '/"linf"/,/relative/p' float.json | sed -n 's/.*"relative": \([-+.e0-9]*\).*/\1/p' | head -n 1 |
    awk '{ exit !($1 > 0 && $1 <= 5.97e-8) }' || fail "the radiosity in PLY is not that in VTP as a float"

# Only errors, no table.
expect_exit 0 "$compare" coarse.vtp fine.vtp quiet.vtp --quiet
[ ! -s stdout ] && [ ! -s stderr ] || fail "--quiet is not"
expect_exit 0 "$compare" --help
expect_text stdout "Examples:" "compare_fields out.vtp fine.vtp error.vtp" "Exit codes" --max-distance
expect_exit 0 "$compare" --version
expect_text stdout "compare_fields " CGAL

# Usage.
refused 1 "two fields are expected"
refused 1 "two fields are expected" coarse.vtp
refused 1 "\`fourth\` is one argument too many" coarse.vtp fine.vtp error.vtp fourth
refused 1 "unknown option --aray, did you mean --array?" coarse.vtp fine.vtp --aray radiosity
refused 1 "must end in .vtp" coarse.vtp fine.vtp errors.ply
refused 1 "must end in .vtp" coarse.vtp fine.vtp errors
for bad in 0 -1 nan 1m; do
    refused 1 "--max-distance $bad: must be a positive number" coarse.vtp fine.vtp "--max-distance=$bad"
done
refused 1 "--threads 0: must be a whole number of at least 1" coarse.vtp fine.vtp --threads 0
refused 1 "must be at most 1024" coarse.vtp fine.vtp --threads 1025

# Nothing over an input or another output, by whatever name.
cp coarse.vtp coarse.copy
cp fine.vtp fine.copy
ln -s fine.vtp link.vtp
mkdir deeper
refused 1 "would overwrite the result" coarse.vtp fine.vtp deeper/../coarse.vtp
refused 1 "would overwrite the reference" coarse.vtp fine.vtp link.vtp
refused 1 "would overwrite the reference" coarse.vtp fine.vtp new.vtp --report "$PWD/fine.vtp"
refused 1 "two outputs have this name" coarse.vtp fine.vtp new.vtp --report ./new.vtp
refused 4 "the directory \`nowhere\` does not exist" coarse.vtp fine.vtp nowhere/error.vtp
cmp coarse.vtp coarse.copy && cmp fine.vtp fine.copy || fail "an input has changed"

# Input.
refused 2 "missing.vtp: cannot be opened" missing.vtp fine.vtp new.vtp
refused 2 "did you mean 'reflectance'?" coarse.vtp fine.vtp new.vtp --array reflectanse
refused 2 "and no triangles" sites.vtp fine.vtp new.vtp
refused 2 "fields are read from .vtp or .ply" "$box" fine.vtp new.vtp
head -c 9000 coarse.vtp >cut.vtp
refused 2 "cut.vtp: is not a complete VTK XML PolyData file" cut.vtp fine.vtp new.vtp
head -c 9000 coarse.ply >cut.ply
refused 2 "cut.ply" fine.vtp cut.ply new.vtp
[ "$(wc -l <stderr)" -le 3 ] || fail "more than progress and a message"
refused 2 "coarse.ply: has no point array 'display'; it has: display_rgb, radiosity_weighted" coarse.ply fine.vtp new.vtp --array display
expect_exit 0 "$bake" "$DIFUSA_DATA/bowl.ply" bowl.vtp $small --quiet
refused 2 "no part of bowl.vtp lies on fine.vtp" bowl.vtp fine.vtp new.vtp

# A part of the surface only: a floor, of which a quarter is on the reference.
for side in 1 2; do
    printf 'v 0 0 0\nv %s 0 0\nv %s %s 0\nv 0 %s 0\nf 1 2 3 4\n' $side $side $side $side >floor.obj
    expect_exit 0 "$bake" floor.obj floor_$side.vtp $small --sky 1 --output-spacing 0.1 --quiet
done
refused 2 "of the area of floor_2.vtp lies on floor_1.vtp" floor_2.vtp floor_1.vtp new.vtp
expect_text message "only 2" "in the same unit and position?" "--min-match"
expect_exit 0 "$compare" floor_2.vtp floor_1.vtp --min-match 20%
expect_text stdout "is excluded from the norms"
expect_exit 0 "$compare" floor_1.vtp floor_2.vtp
refused 1 "--min-match 101%: must be at most 100%" floor_2.vtp floor_1.vtp --min-match 101%

# All files, or none.
limited() {
    (
        ulimit -f 8
        "$@"
    )
}
echo old >new.vtp
echo old >new.json
code=0
limited "$compare" coarse.vtp fine.vtp new.vtp --report new.json >stdout 2>stderr || code=$?
[ "$code" = 4 ] || fail "exit $code on a full disk"
expect_text stderr "File too large"
[ "$(cat new.vtp new.json | sort -u)" = old ] || fail "a failed comparison has replaced a file"
