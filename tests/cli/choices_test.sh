# Every transport, basis, visibility, solver and sampler bakes the Cornell box to a finite field in which no light is lost.
. "$(dirname "$0")/lib.sh"

few="--spacing 0.065 --rays 16 --output-spacing 0.3" # 400 sites, and no more output points than faces need
most_lost=0.2
if [ $sanitized = yes ]; then # what is computed matters there, not how well
    few="--spacing 0.11 --rays 16 --output-spacing 1 --error-points 16"
    most_lost=0.5
fi

# converged CHOICE: the bake ends with a solution, the numbers of its balance are numbers, and what was emitted is
# absorbed or escapes within a fifth, so few sites and rays these are.
converged() {
    expect_exit 0 "$bake" "$box" out.vtp $few $1 --report report.json --quiet
    expect_text report.json '"reason": "converged"'
    sed -n '/"energy"/,/^  }/p' report.json >energy
    case $1 in
    *gather*)
        expect_no_text energy null # what is not finite
        sed -n '/"imbalance"/,/]/p' energy | tr -d ' ,' | awk -v most=$most_lost '/^-?[0-9]/ { n++; if ($1 > most || $1 < -most) bad = 1 }
            END { exit bad || n != 3 }' || fail "energy is lost: $1: $(cat energy)"
        ;;
    *) # without rays nobody knows what escapes: absorbed is less than emitted
        sed -n '/"absorbed"/,/]/p; /"emitted"/,/]/p' energy | tr -d ' ,' | awk '/^-?[0-9]/ { n++; x[n] = $1 }
            END { for (c = 1; c <= 3; c++) if (!(x[c + 3] > 0.3 * x[c] && x[c + 3] < x[c])) bad = 1
                  exit bad || n != 6 }' || fail "absorbed: $1: $(cat energy)"
        ;;
    esac
}

# converged_or_said CHOICE: a solution, or no field at all and exit 3 with the reason and what to do.
converged_or_said() {
    local code=0
    rm -f out.vtp
    "$bake" "$box" out.vtp $few $1 --report report.json --quiet >stdout 2>stderr || code=$?
    case $code in
    0)
        expect_text report.json '"reason": "converged"'
        solved=$((solved + 1))
        ;;
    3)
        grep -Eq 'spectral radius is [0-9.]+|misses a constant by [0-9.]+ %' stderr || fail "no reason: $1"
        grep -Eq ': use --|, or use --' stderr || fail "no remedy: $1"
        [ ! -e out.vtp ] || fail "a field that means nothing was written: $1"
        ;;
    *) fail "exit $code: $1" ;;
    esac
}

"$bake" --list-plugins >plugins
engines=cgal
if grep -q '^  embree ' plugins; then
    engines="cgal embree"
fi
for transport in gather pairwise; do
    solved=0
    for sampler in poisson-disk view-driven; do
        for visibility in $engines; do
            # Once each is enough to find memory errors.
            case $sanitized/$engines/$sampler/$visibility in
            yes/*embree/poisson-disk/embree | yes/*embree/view-driven/cgal) continue ;;
            esac
            for basis in normalized-radial shepard; do
                converged "--transport $transport --basis $basis --sampler $sampler --visibility $visibility"
            done
            # No partition of unity: with few sites nothing keeps its series from diverging.
            converged_or_said "--transport $transport --basis radial --sampler $sampler --visibility $visibility"
        done
    done
    [ "$solved" -ge 1 ] || fail "the radial basis solves next to nothing with $transport transport"
done
for solver in krylov krylov:restart=2 jacobi gauss-seidel:relaxation=1.1 southwell progressive; do
    for transport in gather pairwise; do
        converged "--transport $transport --solver $solver"
        expect_text report.json "\"solver\": \"${solver%%:*}"
    done
done
converged_or_said "--transport gather --basis radial:profile=cubic,width=0.35"
converged "--transport gather --basis shepard:k=3,support=sharp"
converged_or_said "--transport pairwise --kernel point"

# Areas from the neighbours are too large near edges (T 5.5), the cubic swings: such series may diverge.
for basis in normalized-radial shepard radial; do
    converged_or_said "--transport pairwise:areas=neighbours --basis $basis"
    converged_or_said "--transport pairwise:areas=neighbours --basis $basis --kernel point"
done
for transport in gather pairwise; do
    converged_or_said "--transport $transport --basis radial:profile=cubic"
done

# The classical method: bases on a mesh choose their sampler, directions have weights.
for directions in hemicube hemicube:grid=fixed sphere; do
    converged "--transport gather --basis patch-constant --directions $directions"
done
converged "--transport gather --basis patch-constant:display=gouraud --directions sphere"
converged "--transport gather --basis vertex-linear --directions nusselt:grid=fixed"
expect_text report.json '"sampler": "mesh-vertices"' '"directions": "nusselt:grid=fixed"'
expect_refusal 1 "are not for solvers that relax single unknowns" "$bake" "$box" out.vtp --analytic always \
    --solver southwell
expect_refusal 1 "--analytic sometimes: must be one of auto, always, never" "$bake" "$box" out.vtp --analytic sometimes
expect_refusal 1 "use a random grid" "$bake" "$box" out.vtp --error 5% --directions sphere:grid=fixed
expect_refusal 1 "omit its resolution" "$bake" "$box" out.vtp --error 5% --directions hemicube:resolution=8
expect_refusal 1 "belong to the sites of --sampler patch-centres" "$bake" "$box" out.vtp --basis patch-constant \
    --sampler poisson-disk
expect_refusal 1 "--adaptive: adds sites where they help" "$bake" "$box" out.vtp --basis vertex-linear --adaptive
expect_refusal 1 "whose resolution means 48 rays; omit --rays" "$bake" "$box" out.vtp --rays 16 \
    --directions hemicube:resolution=4
expect_exit 0 "$bake" "$box" out.vtp --spacing 0.3 --error-points 0 --directions hemicube:resolution=4 --quiet

# Patches divided where the light varies.
expect_exit 0 "$bake" "$box" out.vtp $few --basis patch-constant --adaptive --levels 2 --report report.json
expect_text stdout "elements: parts of " " patches, quartered up to 2 times in a row"
expect_text report.json '"subdivision": {' '"levels": 2' '"projection": "substructured"' '"pilot bake"'
expect_refusal 1 "patch-constant, shown flat" "$bake" "$box" out.vtp --basis patch-constant:display=gouraud --adaptive
expect_refusal 1 "--levels: limits how finely patches are divided" "$bake" "$box" out.vtp --levels 2 --adaptive
expect_refusal 1 "--levels: limits how finely --adaptive divides patches, and --error adds sites instead" \
    "$bake" "$box" out.vtp --levels 2 --error 50%
expect_refusal 1 "--levels: must be from 1 to 8" "$bake" "$box" out.vtp --basis patch-constant --adaptive --levels 9
