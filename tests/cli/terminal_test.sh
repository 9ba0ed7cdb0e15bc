# What a person sees: nothing with --quiet, lines of progress in a pipe, one line on a terminal; help, version, plugins.
. "$(dirname "$0")/lib.sh"

expect_exit 0 "$bake" "$box" out.vtp $small --quiet --sites-output sites.vtp --report report.json
[ ! -s stdout ] && [ ! -s stderr ] || fail "--quiet is not quiet"
expect_exit 0 "$bake" "$DIFUSA_DATA/ugly.off" out.vtp $small --quiet
[ ! -s stdout ] && [ ! -s stderr ] || fail "--quiet is not quiet about a bad mesh"
expect_exit 0 "$bake" "$box" --dry-run $small --quiet
[ ! -s stdout ] && [ ! -s stderr ] || fail "--dry-run --quiet is not quiet"

expect_exit 0 "$bake" "$box" out.vtp $small --sites-output sites.vtp --report report.json
expect_text stdout "20 faces, 38 triangles" "sites: " "solve: converged after" "energy (W" "time: " "peak memory" \
    "written: out.vtp" "written: sites.vtp" "written: report.json"
for phase in read "check mesh" "place sites" transport "direct light" solve "estimate error" evaluate write; do
    [ "$(grep -cx "$phase" stderr)" = 1 ] || fail "the phase $phase is not told once, in a line of its own"
done
[ "$(tr -d '\12\40-\176' <stderr | wc -c)" = 0 ] || fail "control characters in a pipe"
[ -z "$(sort stdout | uniq -d)" ] || fail "lines are repeated: $(sort stdout | uniq -d)"

# The default engine is named by what it is.
engine=cgal
if "$bake" --list-plugins | grep -q '^  embree '; then
    engine=embree
fi
expect_exit 0 "$bake" "$box" out.vtp $small --verbose
expect_text stdout "basis: moving-least-squares:width=1" "visibility: $engine" "time, transport: " "residuals, channel 2: "

# On a terminal: one line, rewritten, wiped at the end. With as many rays as it takes to see some progress.
for rays in 128 1024 8192; do
    expect_exit 0 script -qec "$bake $box out.vtp --sites 1000 --rays $rays --threads 1" typescript
    if grep -q " s left" typescript; then
        break
    fi
done
expect_text typescript "transport ..." " %, " " s left"
escape=$(printf '\033[K')
expect_text typescript "$escape"
[ "$(grep -c "s left" typescript)" = 1 ] || fail "progress takes more than a line"
expect_exit 0 script -qec "$bake $box out.vtp $small --quiet" typescript
expect_no_text typescript "transport"

# Warnings come with a count, a place and a remedy, each kind once.
expect_exit 0 "$bake" "$DIFUSA_DATA/ugly.off" out.vtp $small
expect_text stdout "repaired: 2 duplicate faces: left out" "(line " "note: nothing emits light: a uniform sky"

# In a pipe each phase has a line, and only those that there are.
expect_text stderr "transport" "evaluate" "write"
expect_no_text stderr "write convergence"

# Output that nobody takes is not a success.
if [ -e /dev/full ]; then
    code=0
    "$bake" "$box" out.vtp $small >/dev/full 2>stderr || code=$?
    [ "$code" = 4 ] || fail "exit $code with a full standard output"
    expect_text stderr "cannot write to standard output"
fi

expect_exit 0 "$bake" "$box" kept.ply $small
for lost in "1" "1 2" "0 1 2"; do
    rm -f out.ply
    code=0
    (
        for stream in $lost; do
            eval "exec $stream>&-"
        done
        exec "$bake" "$box" out.ply $small
    ) >stdout 2>stderr || code=$?
    [ "$code" = 4 ] || fail "exit $code without the streams $lost"
    expect_same_field kept.ply out.ply
done
"$bake" "$box" out.ply $small >stdout 2>&- || fail "a closed standard error is an error"
expect_same_field kept.ply out.ply
rm out.ply
(
    code=0
    "$bake" "$box" out.ply $small 2>stderr || code=$?
    echo $code >code
) | true
[ "$(cat code)" = 4 ] || fail "exit $(cat code) with a standard output that nobody reads"
expect_same_field kept.ply out.ply

for option in --help -h; do
    expect_exit 0 "$bake" $option
    [ ! -s stderr ] || fail "$option writes on standard error"
    [ "$(grep -n -m 1 '^Examples' stdout | cut -d: -f1)" -lt "$(grep -n -m 1 -e --basis.*elements -e --sampler stdout | cut -d: -f1)" ] ||
        fail "the examples are not first"
    expect_text stdout --basis --sampler --spacing --sites --neighbours --transport --directions --rays --kernel \
        --visibility --solver --tolerance --stop --max-iterations --convergence --reflectance --sky --output-spacing --sites-output --report \
        --seed --threads --plugin-path --quiet --verbose --version --dry-run --list-plugins "Exit codes:"
done
expect_exit 0 "$bake" --version
expect_text stdout "bake_radiosity " "CGAL " "Eigen " "OpenMesh " "VTK "
expect_exit 0 "$bake" --list-plugins
expect_text stdout basis directions kernel reader sampler solver visibility normalized-radial shepard poisson-disk \
    view-driven low-discrepancy disc point cgal krylov jacobi gauss-seidel southwell progressive "profile=gaussian" .so
expect_no_text stdout refused

# A damaged module is told about and passed over.
mkdir modules
printf 'no module' >modules/broken.so
expect_exit 0 "$bake" --plugin-path modules --list-plugins
expect_text stdout refused modules/broken.so
expect_exit 0 "$bake" "$box" out.vtp $small --plugin-path modules --quiet
