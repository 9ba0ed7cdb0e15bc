# A building of more than a quarter of a million triangles, nearly all of them in fluted columns: nothing in it has to be
# mended, and no light is lost between what it is put together from: all that leaves goes through the windows.
. "$(dirname "$0")/lib.sh"
expect_exit 0 "$DIFUSA_BIN/generate_scenes" hall
if [ $sanitized = no ]; then # many triangles under a sanitizer: million_triangles_test.sh
    expect_exit 0 "$bake" hall.obj out.vtp --dry-run --sites 400 --report report.json
    if grep -E '^(repaired|noticed): ' stderr stdout; then
        fail "the hall has to be mended"
    fi
    found=$(entry report.json triangles)
    [ -n "$found" ] && [ "$found" -ge 250000 ] || fail "$found triangles"
fi

# Edges of one face alone are where the windows end, 243 on either side: of each of nine windows the sill, two jambs and
# 24 segments of the head.
awk '/^f / {
         for (i = 2; i <= NF; ++i) {
             from = $i; to = i < NF ? $(i + 1) : $2
             if ((to, from) in open) delete open[to, from]
             else open[from, to]
         }
     }
     END { for (edge in open) ++count; print count + 0 }' hall.obj >count
[ "$(cat count)" = $((2 * 9 * (1 + 2 + 24))) ] || fail "$(cat count) edges of one face alone"
