# Every way a bake can end: 0 done, 1 usage (arguments_test.sh has them all), 2 input, 3 not converged, 4 resources,
# 130 interrupted. No failure leaves a file, or touches one that was there.
. "$(dirname "$0")/lib.sh"

expect_exit 0 "$bake" "$box" kept.ply $small
cp kept.ply copy.ply
expect_refusal 1 "--rays" "$bake" "$box" kept.ply --rays none

# 2: input.
expect_refusal 2 "missing.off: cannot be opened" "$bake" missing.off kept.ply
expect_refusal 2 "is a directory" "$bake" "$DIFUSA_DATA" kept.ply
printf 'words\n' >words.txt
expect_refusal 2 "there are readers for: " "$bake" words.txt kept.ply
expect_text message .obj .off .ply .stl
printf 'OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n' >short.off
expect_refusal 2 "short.off" "$bake" short.off kept.ply
printf 'OFF\n0 0 0\n' >empty.off
expect_refusal 2 "empty.off" "$bake" empty.off kept.ply
: >nothing.off
expect_refusal 2 "nothing.off" "$bake" nothing.off kept.ply
printf 'OFF\n3 1 0\n0 0 0\n1 0 0\n0 nan 0\n3 0 1 2\n' >nan.off
expect_refusal 2 "nan.off:6: point 2 (line 5)" "$bake" nan.off kept.ply
printf 'OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n' >range.off
expect_refusal 2 "range.off:6" "$bake" range.off kept.ply

# 3: an accuracy that is out of reach; the best result is written only where that is asked for.
expect_refusal 3 "the error is not below 0.01 %: below " "$bake" "$box" kept.ply --error 0.01% --max-sites 200
expect_exit 3 "$bake" "$box" best.ply --error 0.01% --max-sites 200 --best-effort --error-chart best.svg
expect_text stdout "attempt 1: " "written: best.ply" "written: best.svg"
expect_text best.svg "ordered" "97.5 % end"
expect_text stderr "the files hold the best result"
[ -s best.ply ] || fail "--best-effort wrote nothing"

# Scenes that double precision cannot hold.
tetrahedron() { # tetrahedron OFFSET SIZE
    awk -v o="$1" -v s="$2" 'BEGIN {
        print "OFF\n4 4 0"
        printf "%.17g %.17g %.17g\n%.17g %.17g %.17g\n", o, o, o, o + s, o, o
        printf "%.17g %.17g %.17g\n%.17g %.17g %.17g\n", o, o + s, o, o, o, o + s
        print "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3"
    }'
}
tetrahedron 1e15 1 >far.off
expect_refusal 2 "at coordinates up to 1e+15, which leave too few digits for it: move it to the origin" \
    "$bake" far.off kept.ply
tetrahedron 1e14 1 >far.off
expect_refusal 2 "move it to the origin, or give a larger --spacing" "$bake" far.off kept.ply --sites 200
tetrahedron 0 1e-100 >tiny.off
expect_refusal 2 "use a smaller unit of length" "$bake" tiny.off kept.ply
tetrahedron 0 1e-200 >tiny.off
expect_refusal 2 "use a smaller unit of length" "$bake" tiny.off kept.ply
tetrahedron 0 1e-50 >tiny.off
expect_exit 0 "$bake" tiny.off small.ply $small

# A closed box of which all faces look inward: no sky comes in, and nothing emits.
closed_cube >closed.off
expect_refusal 2 "no light reaches the front of any face" "$bake" closed.off kept.ply $small --flip none
expect_text message Ke
expect_exit 0 "$bake" closed.off flipped.ply $small # light meets its backs alone
expect_text stdout "1 connected part inside out: turned over"
rm flipped.ply
expect_refusal 2 "all lights of the scene are dark" "$bake" closed.off kept.ply $small --sky 0
expect_text message "--sky 1" Ke
# A file that states lights is not given others if they are dark.
for lights in '"sky": {"type": "uniform", "irradiance": 0}' \
    '"lights": [{"type": "point", "position": [0.5, 0.5, 0.5], "power": 0}]' \
    '"lights": [{"type": "sun", "towards": [0, 0, 1], "irradiance": 0}]'; do
    printf '{"difusa_scene": 1, "meshes": [{"file": "closed.off"}], %s}' "$lights" >dark.json
    expect_refusal 2 "all lights of the scene are dark" "$bake" dark.json kept.ply $small
done

# 3: no trustworthy solution.
expect_refusal 3 "stopped at the limit of iterations" "$bake" "$box" kept.ply $small --max-iterations 1
expect_text message --max-iterations --tolerance
expect_refusal 3 "does not converge: its spectral radius is" "$bake" "$box" kept.ply --sites 300 --rays 16 \
    --transport pairwise:areas=neighbours --kernel point
expect_text message "--transport gather" "--kernel disc"
sed -e 's/^Kd.*/Kd 1 1 1/' "$DIFUSA_DATA/furnace_box.mtl" >furnace_box.mtl
cp "$DIFUSA_DATA/furnace_box.obj" .
expect_refusal 3 "closed scene that absorbs nothing" "$bake" furnace_box.obj kept.ply $small

# 4: resources.
expect_refusal 4 "the directory \`nowhere\` does not exist" "$bake" "$box" nowhere/out.vtp
[ "$(wc -l <stderr)" = 1 ] || fail "the missing directory was found after the work"
limited() { # limited KIB_OF_FILES COMMAND...
    (
        ulimit -f "$1"
        shift
        "$@"
    )
}
expect_refusal 4 "kept.ply" limited 4 "$bake" "$box" kept.ply $small
expect_text message "File too large" "ulimit -f"
# Memory that the starting process holds is not counted.
large() { # large COMMAND...: started by a process that holds 200 MB
    (
        held=$(head -c 200000000 /dev/zero | tr '\0' x)
        [ ${#held} = 200000000 ] && "$@"
    )
}
expect_exit 0 large "$bake" "$box" small.ply $small --max-memory 150MB
crowded() { # crowded KIB_OF_MEMORY COMMAND...
    (
        ulimit -v "$1"
        shift
        "$@"
    )
}
soon=4000 # ms
sites=4000
if [ $sanitized = yes ]; then
    soon=40000
    sites=500 # which are there earlier; their rays take a minute
else # sanitizers reserve more address space than there is memory
    expect_refusal 4 "of which nine tenths may be used: give a larger --spacing, or fewer --rays" crowded 400000 "$bake" "$box" kept.ply \
        --sites 9000 --rays 100000
    expect_text message "sites and its output would take about" MiB
fi

# 130: interrupted during transport, after the sites that are under way, and without a trace.
set -m # else a shell without a terminal lets its background jobs ignore SIGINT
for signal in INT TERM HUP; do
    : >stderr # else what an earlier run has told is taken for this one's
    ls -A . >before
    "$bake" "$box" kept.ply --sites $sites --rays 4096 >stdout 2>stderr &
    job=$!
    for _ in $(seq 300); do
        grep -qx transport stderr && break
        sleep 0.1
    done
    grep -qx transport stderr || fail "transport did not begin"
    sleep 0.2
    begin=$(date +%s%N)
    kill -s "$signal" "$job"
    code=0
    wait "$job" || code=$?
    took=$((($(date +%s%N) - begin) / 1000000))
    [ "$code" = 130 ] || fail "exit $code after SIG$signal"
    [ "$took" -lt "$soon" ] || fail "SIG$signal was obeyed after $took ms"
    expect_text stderr "bake_radiosity: interrupted"
    ls -A . >after
    cmp -s before after || fail "the files have changed: $(diff before after)"
done
# While input is read, at once.
awk 'BEGIN { print "OFF 600000 1 0"; for (i = 0; i < 600000; i++) print i % 7, i, 0; print "3 0 1 2" }' >long.off
: >stderr
"$bake" long.off long.vtp >stdout 2>stderr &
job=$!
until grep -qx read stderr; do
    kill -0 "$job" || fail "reading did not begin"
    sleep 0.01
done
kill "$job"
code=0
wait "$job" || code=$?
[ "$code" = 130 ] || fail "exit $code while input is read"
[ "$(cat stderr)" = "read
bake_radiosity: interrupted" ] || fail "not stopped while input is read: $(cat stderr)"
rm long.off
set +m

cmp kept.ply copy.ply || fail "a failed bake has touched an older file"
