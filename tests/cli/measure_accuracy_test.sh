# measure_accuracy writes what it measures, and refuses what is wrong before the work.
. "$(dirname "$0")/lib.sh"
measure=$DIFUSA_BIN/measure_accuracy

expect_refusal 1 "a directory for the results is expected" "$measure"
expect_refusal 1 "did you mean sphere?" "$measure" --output study --case spere
expect_refusal 1 "did you mean 'shepard'?" "$measure" --output study --case sphere --basis shepherd
expect_refusal 1 "unknown option --bases, did you mean --basis?" "$measure" --output study --bases shepard
expect_refusal 1 "--spacing 0: must be a positive number" "$measure" --output study --spacing 0
expect_refusal 1 "--rays 0" "$measure" --output study --rays 0
echo "in the way" >file
expect_refusal 4 "file/study: cannot be created" "$measure" --output file/study --case sphere

expect_exit 0 "$measure" --help
expect_text stdout "Cases: ball-over-disc"

expect_exit 0 "$measure" --output study --case sphere --basis shepard --basis radial:width=5 --projection natural \
    --projection corrected:in=equation --spacing 0.8 --spacing 0.6 --rays 16 --places 200
expect_text stdout "sphere, shepard, spacing 0.8" "does not converge" "written: study"
# Shepard's basis interpolates: there is nothing to correct.
[ "$(wc -l <study/measurements.csv)" = 7 ] || fail "six measurements and a header were expected"
expect_text study/measurements.json '"schema": "difusa-accuracy-study"' '"bound_over_error"'
expect_text study/sphere.md "| radial:width=5, corrected:in=equation | 0.6 | 16 |"
expect_text study/sphere_error_against_time.svg "<svg" "shepard"
expect_text study/sphere_error_against_sites.svg "</svg>"

expect_exit 0 "$measure" --output chapter --chapter7 --basis shepard --spacing 8 --rays 16 --quiet
[ ! -s stdout ] || fail "--quiet was not"
[ "$(find chapter -name '*.svg' | wc -l)" = 12 ] || fail "two transports of six curves were expected"
expect_text chapter/chapter7.md "| pairwise | shepard | 8 |" "disc, indirect"
[ "$(wc -l <chapter/chapter7.csv)" = 1201 ] || fail "twelve curves of a hundred places and a header were expected"
