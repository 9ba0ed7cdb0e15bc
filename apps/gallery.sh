#!/usr/bin/env bash
# Makes the pictures of the gallery and the table of the dissertation's rooms: apps/gallery.sh DIRECTORY [--quick]
# Everything is written to DIRECTORY: one PNG per picture, the reports of the bakes, rooms.md. --quick: small pictures
# of coarse bakes, to check that everything works. Programs are taken from $DIFUSA_BIN, otherwise from the first of
# build/release/bin, build/quickstart/bin and build/bin that has them.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

usage() {
    echo "usage: apps/gallery.sh DIRECTORY [--quick]" >&2
    exit 1
}
if [ $# -lt 1 ] || [ $# -gt 2 ] || [ "${1#-}" != "$1" ] || [ "${2:---quick}" != --quick ]; then
    usage
fi
out=$1
quick=${2:-}

bin=${DIFUSA_BIN:-}
for candidate in "$root"/build/{release/bin,quickstart/bin,bin}; do
    if [ -z "$bin" ] && [ -x "$candidate/render_view" ]; then
        bin=$candidate
    fi
done
if [ ! -x "$bin/render_view" ]; then
    echo "error: render_view is not built; run apps/quickstart.sh, or set DIFUSA_BIN to where it is" >&2
    exit 4
fi
data=${DIFUSA_DATA:-$root/data}
mkdir -p "$out/reports"

visibility=cgal
if "$bin/bake_radiosity" --list-plugins | grep -q '^  embree '; then
    visibility=embree
fi
common=(--visibility "$visibility" --quiet)
room_quality=(--size 800 600 --samples 9)
quality=(--size 800 800 --samples 16 --rays 1024)
box_sites=8000
hall_quality=(--size 1280 720 --samples 9 --sites 20000)
mirror_quality=(--size 800 600 --samples 9 --sites 10000 --rays 1024)
gloss_quality=(--size 560 350 --samples 36 --directional-order 12 --tone filmic)
if [ -n "$quick" ]; then
    room_quality=(--size 160 120 --samples 1 --rays 32)
    quality=(--size 160 160 --samples 1 --rays 64)
    box_sites=800
    hall_quality=(--size 160 90 --samples 1 --rays 64 --sites 1000)
    mirror_quality=(--size 160 120 --samples 1 --rays 64 --sites 1000)
    gloss_quality=(--size 160 100 --samples 1 --rays 64 --sites 1000 --directional-order 4)
fi

# The first number (or word) of this name in a report.
entry() {
    sed -n "s/^ *\"$2\": *\"\{0,1\}\([^\",]*\)\"\{0,1\},\{0,1\}\$/\1/p" "$1" | head -n 1
}

# The number of sites in a report.
site_count() {
    awk '/^  "sites": \{/ { on = 1 } on && /"count":/ { gsub(/[^0-9]/, ""); print; exit }' "$1"
}

# The wall time of all phases of a bake.
bake_seconds() {
    awk '/^  "seconds": \[/ { on = 1 } on && /"seconds": [0-9]/ { gsub(/[^0-9.e+-]/, "", $2); sum += $2 }
        END { printf "%.1f", sum }' "$1"
}

# render PICTURE SCENE OPTION...: makes $out/PICTURE.png, printing its name. Fails as render_view does.
render() {
    local picture=$1 scene=$2
    shift 2
    echo "$picture ..."
    "$bin/render_view" "$scene" "$out/$picture.png" "${common[@]}" "$@"
}

# The rooms of the dissertation: each in its three bases, all light and the direct light alone. The spacing stated there
# gives about a quarter of the stated number of sites, half that spacing about the stated number: both are shown.
table=$out/rooms.md
rows=$(mktemp)
trap 'rm -f "$rows"' EXIT
room() { # room NAME SPACING PRINTED_SITES: its pictures and rows of the table
    local basis name report code error label
    label=$(printf '%s' "$1" | tr '[:lower:]' '[:upper:]')
    for basis in radial normalized-radial shepard; do
        name=room_${1}_${basis}_$2
        report=$out/reports/$name.json
        code=0
        render "${name}_global" "$data/room_$1.json" --basis "$basis" --spacing "$2" "${room_quality[@]}" \
            --also "direct=$out/${name}_direct.png" --report "$report" || code=$?
        if [ "$code" = 3 ]; then
            echo "| $label | $basis | $2 | – | $3 | does not converge | | |" >>"$rows"
            continue
        fi
        [ "$code" = 0 ] || exit "$code"
        error=$(entry "$report" relative_high)
        case $error in
        '' | null) error=– ;;
        *) error=$(awk -v e="$error" 'BEGIN { printf "%.2g %%", 100 * e }') ;;
        esac
        echo "| $label | $basis | $2 | $(site_count "$report") | $3 | $(entry "$report" iterations) |" \
            "$(bake_seconds "$report") | $error |" >>"$rows"
    done
}
room a 8 4358
room a 4 4358
room b 9 1812
room b 4.5 1812
room c 8 4358
room c 4 4358
room d 9 3812
room d 4.5 3812
{
    echo "| room | basis | spacing | sites | sites in the dissertation | iterations | seconds | error at most |"
    echo "|---|---|---|---|---|---|---|---|"
    cat "$rows"
} >"$table"
echo "$table"

# The Cornell box: all light, its parts, the sites, one basis element, the estimated error.
box=$data/cornell_box.json
render cornell_box "$box" "${quality[@]}" --sites "$box_sites" --projection galerkin --tone filmic \
    --also "direct=$out/cornell_box_direct.png" --also "indirect=$out/cornell_box_indirect.png"
few=("${quality[@]}" --sites 600)
render cornell_box_sites "$box" "${few[@]}" --show sites --also "error=$out/cornell_box_error.png" --log
render basis_element "$box" "${quality[@]}" --sites 200 --show basis --near 0.15,0.38,0.5592

render mirror_room "$data/mirror_room.json" "${mirror_quality[@]}" --tone filmic
render glossy_floor "$data/glossy_floor.json" "${gloss_quality[@]}"
render glossy_floor_right "$data/glossy_floor.json" "${gloss_quality[@]}" --eye 4.5,0.3,1.2 --look-at 1.2,3.0,0.5
render oven "$data/oven.json" "${mirror_quality[@]}"

# A large hall, generated rather than stored.
if [ -x "$bin/generate_scenes" ]; then
    "$bin/generate_scenes" --directory "$out/scenes" hall
    render hall "$out/scenes/hall.json" "${hall_quality[@]}" --tone filmic --report "$out/reports/hall.json"
else
    echo "hall: skipped, since generate_scenes is not built (it comes with the tests)"
fi
echo "written to $out"
