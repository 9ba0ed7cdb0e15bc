# A million triangles: a closed room with walls in fine triangles and three balls. All of it emits 1 and reflects half, so
# the radiosity is 2 everywhere and what is emitted is absorbed, to rounding. Memory stays below a kilobyte a triangle.
. "$(dirname "$0")/lib.sh"
triangles=1000000
[ $sanitized = no ] || triangles=50000
expect_exit 0 "$DIFUSA_BIN/generate_scenes" room_with_balls $triangles
sed -i -e '/^Ke/d' -e 's/^Kd .*/Kd 0.5 0.5 0.5\nKe 1 1 1/' room_with_balls.mtl
expect_exit 0 "$bake" room_with_balls.obj out.ply --sites 400 --rays 64 --output-spacing 1000 --tolerance 1e-10 \
    --report report.json
found=$(entry report.json triangles)
[ -n "$found" ] && [ "$found" -ge $triangles ] || fail "$found triangles, not $triangles"

awk '/"imbalance"/ { inside = 1; next }
     inside && /\]/ { exit }
     inside { gsub(/[ ,]/, ""); print }' report.json >imbalance
[ -s imbalance ] || fail "no imbalance in the report"
awk '{ if ($1 > 1e-8 || $1 < -1e-8) exit 1 }' imbalance || fail "light is lost or made: $(cat imbalance)"

bytes=$(entry report.json peak_memory_bytes)
[ -n "$bytes" ] || fail "no peak memory in the report"
if [ $sanitized = no ]; then
    [ "$bytes" -lt $((1024 * triangles)) ] || fail "$bytes bytes for $triangles triangles"
fi
