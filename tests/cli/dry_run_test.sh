# A dry run writes nothing but its report, and its numbers are those of the real run or bound them.
. "$(dirname "$0")/lib.sh"

for choice in "--no-adaptive" "--basis shepard --no-adaptive" "--basis radial --no-adaptive" "--transport pairwise --sky 1" "--spacing 0.1 --rays 100" \
    "--sampler view-driven"; do
    case $choice in
    *--spacing*) size= ;;
    *) size="--sites 400 --rays 64" ;;
    esac
    rm -f ./*.json ./*.vtp
    expect_exit 0 "$bake" "$box" out.vtp $size $choice --dry-run --sites-output sites.vtp --report dry.json
    expect_text stdout "sites: " "rays: " "memory for transport: at most" "time: about"
    expect_no_text stdout written:\ out.vtp
    [ ! -e out.vtp ] && [ ! -e sites.vtp ] || fail "a dry run has written a field"
    expect_text dry.json '"dry_run": true'
    expect_exit 0 "$bake" "$box" out.vtp $size $choice --report real.json
    [ "$(entry dry.json count)" != "" ] || fail "no count"
    sites=$(sed -n 's/^sites: \([0-9]*\) .*/\1/p' stdout)
    rays=$(entry real.json rays)
    grep -A 1 '"sites": {' dry.json >dry.sites
    expect_text dry.sites "\"count\": $sites,"
    real_rays=$(sed -n '/"transport": {/,/}/s/^ *"rays": \([0-9]*\),/\1/p' real.json)
    [ "$(entry dry.json estimated_rays)" = "$real_rays" ] || fail "rays: $(entry dry.json estimated_rays), $real_rays"
    further=$(sed -n '/"error": {/,/}/s/^ *"rays": \([0-9]*\),/\1/p' real.json)
    first=$(entry dry.json estimated_further_rays)
    # Noise may take up to eight times the rays, then two rounds double the rays or the points.
    [ "$further" -ge $((first / 2)) ] && [ "$further" -le $((32 * first)) ] ||
        fail "rays of the error estimate: $further, not half to 32 times $first"
    segments=$(entry real.json segments)
    [ "$(entry dry.json estimated_segments)" -ge "$segments" ] || fail "segments: more than estimated"
    bytes=$(entry dry.json estimated_bytes)
    [ "${bytes%.*}" -ge "$(sed -n '/"transport": {/,/}/s/^ *"bytes": \([0-9]*\),*/\1/p' real.json)" ] || fail "memory: more than estimated, $choice"
    # What the process takes, but for what differs from run to run: a page fault earlier or later.
    peak=$(entry dry.json estimated_peak_memory_bytes) taken=$(entry real.json peak_memory_bytes)
    awk "BEGIN { exit !($peak > 0.8 * $taken && $peak < 3 * $taken) }" || fail "memory: $peak of $taken bytes, $choice"
    sed -n '/"estimated_seconds": \[/,/\]/p' dry.json >dry.times
    expect_text dry.times '"phase": "solve"' '"phase": "transport"'
    awk '/"seconds":/ { sum += $2 } END { exit !(sum > 0) }' dry.times || fail "no time was estimated"
done

# Graded sites follow from the light, as many as are wanted to 5 %.
expect_exit 0 "$bake" "$box" out.vtp --sites 1000 --rays 64 --dry-run
expect_text stdout "sites: about 1000, graded"
expect_exit 0 "$bake" "$box" out.vtp --sites 1000 --rays 64
sites=$(sed -n 's/^sites: \([0-9]*\), graded.*/\1/p' stdout)
[ "$sites" -ge 950 ] && [ "$sites" -le 1050 ] || fail "$sites of 1000 graded sites"

# Of very many sites the number is predicted: nothing as large as they are is made.
expect_exit 0 "$bake" "$box" out.vtp --sites 2000000 --rays 16 --no-adaptive --dry-run --report dry.json
expect_text stdout "sites: about "
sites=$(sed -n 's/^sites: about \([0-9]*\) .*/\1/p' stdout)
[ "$sites" -gt 1900000 ] && [ "$sites" -lt 2100000 ] || fail "$sites of 2000000 sites"

# Without an output file, and without any file.
rm -f ./*
expect_exit 0 "$bake" "$box" $small --dry-run
rm -f stdout stderr
[ -z "$(ls -A)" ] || fail "a dry run has written $(ls -A)"
