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
expect_text stdout "ball-over-disc: a ball of radius 5" "1 usage, 2 input, 3 not converged"
expect_refusal 2 "nope.obj: cannot be opened" "$measure" --output nope --estimate 2 --scene nope.obj
expect_refusal 2 "nope.obj: cannot be opened" "$measure" --output nope --solver krylov --scene nope.obj
expect_refusal 1 "--estimate takes a single --rays" "$measure" --output nope --estimate 2 --rays 16 --rays 32
expect_refusal 1 "no case of cie-171 begins so" "$measure" --output nope --validation cie-171 --case 5.10

expect_exit 0 "$measure" --output study --case sphere --basis shepard --basis radial:width=5 --projection natural \
    --projection corrected:in=equation --spacing 0.8 --spacing 0.6 --rays 16 --places 200
expect_text stdout "sphere, shepard, spacing 0.8" "its coefficients oscillate" "written: study"
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

# The classical method beside the meshless one.
expect_refusal 1 "--side-by-side needs a --case or a --scene" "$measure" --output study --side-by-side
expect_refusal 1 "--side-by-side does not take --basis" "$measure" --output study --side-by-side --case sphere \
    --basis shepard
expect_exit 0 "$measure" --output beside --side-by-side --case shelf --sites 100 --rays 48 --places 100
expect_text stdout "| shelf | patches, hemicube |" "| shelf | meshless |" "written: beside"
[ "$(wc -l <beside/side_by_side.csv)" = 7 ] || fail "six methods and a header were expected"
expect_text beside/side_by_side.md "| shelf | vertices, hemicube, exact direct light |"
expect_text beside/shelf_side_by_side.svg "<svg" "meshless"

# The defaults beside others.
expect_refusal 1 "--defaults needs a --case or a --scene" "$measure" --output study --defaults
expect_refusal 1 "--defaults does not take --adaptive" "$measure" --output study --defaults --case sphere --adaptive
expect_refusal 1 "--beside is for the charts of --defaults" "$measure" --output study --case sphere --beside "other=1,2%"
for wrong in other "=1,2%" "other=1" "other=x,2%" "other=1,x"; do
    expect_refusal 1 "--beside $wrong" "$measure" --output study --defaults --case sphere --beside "$wrong"
done
expect_exit 0 "$measure" --output defaults --defaults --case shelf --sites 100 --rays 48 --places 100 \
    --beside "another=2,3%"
expect_text stdout "| shelf | defaults: moving-least-squares, graded |" "| shelf | evenly spaced, shepard |"
[ "$(wc -l <defaults/defaults.csv)" = 7 ] || fail "six methods and a header were expected"
expect_text defaults/shelf_defaults.svg "<svg" "another" "defaults of version 0.1.0"

# The light near edges.
expect_refusal 1 "--edges does not take a single --spacing" "$measure" --output study --edges --spacing 0.1
expect_refusal 1 "--edges does not take --case" "$measure" --output study --edges --case sphere
expect_refusal 1 "--edges does not take a second --rays" "$measure" --output study --edges --rays 48 --rays 96
expect_exit 0 "$measure" --output edges --edges --rays 48 --spacing 0.4 --spacing 0.2 --places 100
expect_text edges/edges.md "| 0.8 | 0.627 | 0.627, "
[ "$(wc -l <edges/edges.csv)" = 17 ] || fail "four reflectances, two spacings, even and graded, and a header were expected"

# Patches divided where the light varies.
expect_refusal 1 "--subdivision needs a --case or a --scene" "$measure" --output study --subdivision
expect_refusal 1 "--subdivision does not take --adaptive" "$measure" --output study --subdivision --case sphere --adaptive
expect_exit 0 "$measure" --output divided --subdivision --case shelf --sites 50 --rays 12 --places 100
expect_text stdout "| shelf | even mesh |" "| shelf | divided patches |" "written: divided"
[ "$(wc -l <divided/subdivision.csv)" = 12 ] || fail "eleven bakes and a header were expected"
expect_text divided/subdivision.md "| shelf | divided, each part for itself |"
expect_text divided/shelf_subdivision.svg "<svg" "even mesh"

# Shelves of finite length.
expect_refusal 1 "--shelf does not take --case" "$measure" --output study --shelf --case shelf
expect_exit 0 "$measure" --output shelves --shelf --spacing 0.5 --places 50
expect_text stdout "| 64 | 0.29" "written: shelves"
[ "$(wc -l <shelves/shelf.csv)" = 8 ] || fail "seven lengths and a header were expected"

# Published validation cases.
expect_refusal 1 "--validation cie-17: unknown, must be cie-171" "$measure" --output study --validation cie-17
expect_refusal 1 "--case 5.10: no case of cie-171 begins so" "$measure" --output study --validation cie-171 --case 5.10
expect_refusal 1 "--validation does not take --solver" "$measure" --output study --validation cie-171 --solver krylov
expect_exit 0 "$measure" --output validation --validation cie-171 --case 5.2 --case "5.9 roof 4x4, sky 5" --spacing 0.5 \
    --rays 64
expect_text stdout "| 5.2 point source | 10 |" "| 5.9 roof 4x4, sky 5 | 14 |" "written: validation"
expect_text validation/validation.md "| 10 of 10 | 0 |"
[ "$(wc -l <validation/validation.csv)" = 25 ] || fail "24 readings and a header were expected"

# Solvers on one system.
expect_refusal 1 "did you mean 'southwell'?" "$measure" --output study --solver soutwell --scene "$box"
expect_refusal 1 "needs a scene" "$measure" --output study --solver krylov
expect_refusal 1 "name them" "$measure" --output study --albedo 0.5
expect_refusal 1 "does not take --case" "$measure" --output study --solver krylov --scene "$box" --case sphere
for albedo in 1 2; do
    expect_refusal 1 "--albedo $albedo: must be above 0 and below 1" "$measure" --output solvers --solver krylov \
        --scene "$box" --albedo $albedo
done
expect_refusal 1 "--spacing says how many there are" "$measure" --output solvers --solver krylov --scene "$box" \
    --spacing 0.1 --sites 100
expect_refusal 1 "takes a single --basis" "$measure" --output solvers --solver krylov --scene "$box" --basis radial \
    --basis shepard
expect_exit 0 "$measure" --output solvers --solver krylov --solver gauss-seidel --solver progressive --scene "$box" \
    --albedo 0.5 --sites 100 --rays 16
expect_text stdout "| cornell_box | 0.5 | 0.01 | krylov |" "written: solvers"
expect_text solvers/solvers.md "| cornell_box | 0.5 | 1e-06 | gauss-seidel |"
for chart in residual_against_iterations residual_against_entries residual_against_seconds error_against_iterations; do
    expect_text solvers/cornell_box_albedo_0.5_$chart.svg "<svg" progressive "</svg>"
done
awk -F, 'NR > 1 && $4 == "progressive" { last = $10 } END { exit !(last <= 1e-6) }' solvers/solvers.csv ||
    fail "the last residual is above the tolerance"

# A series of what the solver passes through: the last is the result.
expect_exit 0 "$bake" "$box" out.vtp $small --solver progressive --convergence steps.pvd --error-points 0
expect_text stdout "written: steps.pvd ("
expect_text steps.pvd 'type="Collection"' 'timestep="0" part="0" file="steps_0000.vtp"'
[ "$(grep -c DataSet steps.pvd)" = "$(ls steps_*.vtp | wc -l)" ] || fail "not all members are listed"
radiosity_of() {
    awk '/Name="radiosity"/ { getline; print }' "$1"
}
[ -n "$(radiosity_of out.vtp)" ] && [ "$(radiosity_of out.vtp)" = "$(radiosity_of "$(ls steps_*.vtp | tail -1)")" ] ||
    fail "the last member is not the result"

# Form factors over mirror patches.
expect_refusal 1 "--mirrors does not take --places" "$measure" --output study --mirrors --places 7
expect_refusal 1 "--edges does not take a --spacing twice" "$measure" --output study --edges --spacing 0.2 --spacing 0.2
mkdir other && cp "$box" other/
expect_refusal 1 "another one is named $(basename "$box" .obj)" "$measure" --output study --defaults --scene "$box" \
    --scene "other/$(basename "$box")"
expect_refusal 1 "--mirrors does not take --case" "$measure" --output study --mirrors --case sphere
expect_exit 0 "$measure" --output mirrors --mirrors --spacing 0.4
expect_text stdout "| single | 1 | 1 | printed | 4 | 8 |" "| double | 4 | 4 | gathered | 1, adaptive |" "written: mirrors"

# Glossy floors. The study itself is long; its parts are tested one by one (Gloss.AgreesWithPathTracing).
expect_refusal 1 "--gloss does not take --spacing" "$measure" --output study --gloss --spacing 0.1
