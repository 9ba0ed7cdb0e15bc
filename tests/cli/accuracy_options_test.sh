# What decides how accurate a bake is, and what it says about it.
. "$(dirname "$0")/lib.sh"

# Wrong choices are refused before the work, with what to do.
expect_refusal 1 "did you mean galerkin?" "$bake" "$box" out.vtp --projection galerkn
expect_refusal 1 "sweeps" "$bake" "$box" out.vtp --projection corrected:sweep=3
expect_refusal 1 "use --transport gather" "$bake" "$box" out.vtp --transport pairwise --projection galerkin
expect_refusal 1 "did you mean interpolated?" "$bake" "$box" out.vtp --direct interpolatd
expect_refusal 1 "unknown option --first-bounce" "$bake" "$box" out.vtp --first-bounce gathered
expect_refusal 1 "unknown option --correction" "$bake" "$box" out.vtp --correction 1
expect_refusal 1 "--final-gather 0: must be a whole number of at least 1" "$bake" "$box" out.vtp --final-gather 0
expect_refusal 1 "--error-points -1" "$bake" "$box" out.vtp --error-points -1
for bad in 0,0,1 0,0,0,1 0,0,1,-1 0,0,1,1,1 up; do
    expect_refusal 1 "the direction towards the sun" "$bake" "$box" out.vtp "--sun=$bad"
done

# Every way gives a field and an estimate of its error; more rays at the output leave less of it.
for way in "--projection natural" "--projection interpolation --basis shepard" "--projection corrected:sweeps=1" \
    "--projection least-squares" "--projection galerkin:points=2" "--basis moving-least-squares --projection galerkin" \
    "--projection corrected:in=equation" "--direct interpolated" "--transport pairwise"; do
    # shellcheck disable=SC2086
    expect_exit 0 "$bake" "$box" out.vtp $small $way --report out.json
    expect_text stdout "error (rms, of the rms reflected radiosity): about"
    expect_text out.vtp error_estimate error_noise error_discretisation
    [ "$(entry out.json relative_high)" != null ] || fail "no estimate with $way"
done
expect_exit 0 "$bake" "$box" out.vtp $small --report plain.json
expect_exit 0 "$bake" "$box" out.vtp $small --final-gather 64 --report gathered.json
awk -v a="$(entry plain.json bound)" -v b="$(entry gathered.json bound)" 'BEGIN { exit !(b < a) }' ||
    fail "the bound of a gathered output, $(entry gathered.json bound), is not below $(entry plain.json bound)"

# Graded sites: about as many, found by pilots whose rays count; an accuracy to order chooses them by itself.
expect_exit 0 "$bake" "$box" out.vtp --sites 400 --rays 64 --adaptive --report graded.json
expect_text stdout "graded, as many as at spacing"
expect_text graded.json '"adaptive": true' '"pilot bake"'
sites=$(sed -n 's/^sites: \([0-9]*\), graded.*/\1/p' stdout)
[ "$sites" -ge 380 ] && [ "$sites" -le 420 ] || fail "$sites graded sites instead of 400, within 5 %"

# That is the default, but for few sites, a given spacing, drafts, light that is not known yet, and sites of other kinds.
expect_exit 0 "$bake" "$box" out.vtp --sites 400 --rays 64
expect_text stdout "sites: $sites, graded, as many as at spacing"
expect_exit 0 "$DIFUSA_BIN/render_view" "$box" out.png --size 8 6 --sites 400 --rays 64
expect_text stdout "sites: $sites, graded,"
for even in "--no-adaptive --sites 400" "--sites 399" "--spacing 0.1" "--quality draft" \
    "--sites 400 --save-transport out.difusa" "--sites 400 --transport pairwise" "--sites 400 --basis patch-constant" \
    "--sites 400 --basis vertex-linear" "--sites 400 --sampler view-driven"; do
    # shellcheck disable=SC2086
    expect_exit 0 "$bake" "$box" out.vtp $even --rays 16 --error-points 0
    expect_no_text stdout ", graded,"
done
expect_refusal 1 "which --sampler view-driven does not place" "$bake" "$box" out.vtp --adaptive --sampler view-driven
expect_refusal 1 "--adaptive: cannot be combined with --error" "$bake" "$box" out.vtp --adaptive --error 1%

# Without an estimate nothing is said, and nothing written.
expect_exit 0 "$bake" "$box" out.vtp $small --error-points 0 --report out.json
expect_no_text stdout "rms reflected"
expect_no_text out.vtp error_estimate
expect_text out.json '"error": null'

# Two suns, on a scene that has no other light: no sky is made up.
expect_exit 0 "$bake" "$DIFUSA_DATA/ball_over_disc.obj" out.vtp $small --sun 0,0,1,0.9 --sun 1,0,1,1,0.5,0.2 --report out.json
expect_text stdout "from suns and point lights"
expect_no_text stdout "uniform sky"
expect_text out.json '"towards"'

# Pairwise transport sees mirrors by patches: without colour, with every solver, and it can be relit.
expect_refusal 1 "coloured mirrors" "$bake" "$DIFUSA_DATA/mirror_room.json" out.vtp --transport pairwise
expect_refusal 1 "or --transport pairwise" "$bake" "$DIFUSA_DATA/mirror_single.json" out.vtp --solver progressive
for paths in gathered shot printed; do
    expect_exit 0 "$bake" "$DIFUSA_DATA/mirror_double.json" out.vtp --sites 200 --rays 32 --error-points 0 \
        --transport "pairwise:mirrors=$paths" --solver progressive --direct interpolated --save-transport out.difusa
    expect_exit 0 "$DIFUSA_BIN/relight" out.difusa again.vtp
done

# Glossy materials: in scenes and pictures, refused where they cannot be, or left out.
glossy="$DIFUSA_DATA/glossy_floor.json"
few="--sites 200 --rays 32 --error-points 0"
expect_exit 0 "$bake" "$glossy" out.vtp $few --directional-order 2 --report out.json
expect_text stdout "harmonics of order 2 hold"
expect_text out.json '"directional_order": 2'
expect_refusal 1 "--directional-order" "$bake" "$glossy" out.vtp --directional-order 21
expect_refusal 1 "cannot be saved" "$bake" "$glossy" out.vtp --save-transport out.difusa
expect_refusal 1 "or --no-gloss" "$bake" "$glossy" out.vtp --transport pairwise
expect_exit 0 "$bake" "$glossy" out.vtp $few --no-gloss --save-transport out.difusa
expect_text stdout "1 glossy material reflects in a lobe is absorbed (--no-gloss)"
expect_exit 0 "$relight" out.difusa again.vtp --error-points 0
expect_exit 0 "$DIFUSA_BIN/render_view" "$glossy" out.png $few --size 40 30 --samples 1 --glossy-rays 1
