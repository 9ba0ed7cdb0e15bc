#!/usr/bin/env bash
# Bakes small scenes and opens what comes out in a real ParaView (by the scripts of apps/paraview) and a real MeshLab,
# without a screen; checks what they show and say against the files. The pictures stay in OUT_DIR.
#   tests/viewers/run.sh BIN_DIR OUT_DIR
# PYTHONPATH must lead to ParaView's Python modules unless they are installed; tests/run.sh sees to it.
set -euo pipefail

if [ $# -ne 2 ] || [ ! -x "$1/bake_radiosity" ]; then
    echo "usage: $0 BIN_DIR OUT_DIR    (BIN_DIR with the programs built)" >&2
    exit 1
fi
bin=$(cd "$1" && pwd)
out=$(mkdir -p "$2" && cd "$2" && pwd)
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
scripts=$here/../../apps/paraview
data=$here/../../data
for program in Xvfb pvbatch meshlabserver; do
    if ! command -v $program >/dev/null; then
        echo "error: $program is not installed (packages xvfb, paraview, meshlab)" >&2
        exit 4
    fi
done
export PYTHONDONTWRITEBYTECODE=1
cd "$out"
rm -f ./*.png ./*.vtp ./*.ply ./*.log ./*.json ./*.difusa

# One server for all: without -noreset it starts anew whenever a program ends, and refuses the next one meanwhile.
rm -f display
exec 9>display
Xvfb -displayfd 9 -screen 0 1280x1024x24 -noreset -nolisten tcp >xvfb.log 2>&1 &
server=$!
trap 'kill $server 2>/dev/null || true' EXIT
for _ in $(seq 300); do
    [ ! -s display ] || break
    sleep 0.1
done
[ -s display ] || { echo "error: Xvfb does not start:" >&2; cat xvfb.log >&2; exit 4; }
exec 9>&-
DISPLAY=:$(cat display)
export DISPLAY
unset WAYLAND_DISPLAY XAUTHORITY
export QT_QPA_PLATFORM=xcb LIBGL_ALWAYS_SOFTWARE=1

# show NAME SCRIPT ARGUMENT...: a picture NAME.png; what ParaView says is in NAME.log, and no complaint among it.
show() {
    local name=$1 script=$2 file=$3
    shift 3
    if ! timeout 200 pvbatch "$scripts/$script" "$file" "$name.png" "$@" >"$name.log" 2>&1; then
        echo "FAILED: $script $file $*:" >&2
        tail -n 30 "$name.log" >&2
        exit 1
    fi
    if grep -Eiq 'warn|err\||error:|traceback' "$name.log"; then
        echo "FAILED: ParaView complains about $file:" >&2
        cat "$name.log" >&2
        exit 1
    fi
}

few=(--sites 400 --rays 64 --quiet)
from_front=(--eye 0.278 0.273 -0.8 --up 0 1 0 --view-angle 40 --size 400 400)
box=$data/cornell_box.obj

"$bin/bake_radiosity" "$box" box.vtp "${few[@]}"
"$bin/bake_radiosity" "$box" box.ply "${few[@]}"
"$bin/bake_radiosity" "$box" fine.vtp --sites 1500 --rays 128 --quiet
"$bin/bake_radiosity" "$data/courtyard.off" courtyard.vtp --sites 1500 --rays 64 --quiet
"$bin/inspect_basis" "$box" basis.vtp --sites 900 --near 0.42,0,0.12 --sites-output sites.vtp --quiet
"$bin/compare_fields" box.vtp fine.vtp error.vtp --quiet

show box show_bake.py box.vtp "${from_front[@]}"
show luminance show_bake.py box.vtp --array radiosity_weighted "${from_front[@]}"
show courtyard show_bake.py courtyard.vtp --size 400 300
show element show_basis.py basis.vtp --sites sites.vtp --supports --towards 0 -0.5 1 --up 0 1 0 --size 640 480
show sum show_basis.py basis.vtp --array sum --towards 0 0 1 --up 0 1 0 --size 640 480
show error show_error.py error.vtp --towards 0 0 1 --up 0 1 0 --size 640 480
show signed show_error.py error.vtp --array radiosity_error_rgb:0 --towards 0 0 1 --up 0 1 0 --size 640 480
timeout 200 pvbatch "$here/use_macro.py" "$scripts/difusa_macro.py" box.vtp macro.png materials.png >macro.log 2>&1 &&
    ! grep -Eiq 'warn|err\||error:|traceback' macro.log ||
    { echo "FAILED: the macro:" >&2; cat macro.log >&2; exit 1; }
# The plugin that relights: half the lamp, a sky, and a sun in the north, 20 degrees high.
"$bin/bake_radiosity" "$box" saved.vtp "${few[@]}" --error-points 0 --save-transport saved.difusa
relight() { "$bin/relight" saved.difusa "$1.vtp" --quiet --error-points 0 "${@:2}"; }
relight half --scale lamp=0.5
relight sky --scale lamp=0 --sky 2
relight sun --scale lamp=0 --sun 0,0.34202014332566871,-0.93969262078590838,30
open_saved() {
    DIFUSA_RELIGHT=$1 timeout 200 pvbatch "$here/use_relight.py" "$scripts/difusa_relight.py" "$2.png" saved.difusa \
        half.vtp sky.vtp sun.vtp >"$2.log" 2>&1
}
open_saved "$bin/relight" relight && ! grep -Eiq 'warn|err\||error:|traceback' relight.log ||
    { echo "FAILED: the plugin that relights:" >&2; cat relight.log >&2; exit 1; }
if open_saved /nowhere/relight none || ! grep -q "difusa: the program /nowhere/relight cannot be found" none.log; then
    echo "FAILED: a program that is not there:" >&2
    cat none.log >&2
    exit 1
fi
# The file becomes that of another scene, whose sky was assumed for want of lights: half of it, another sky, and a sun.
"$bin/bake_radiosity" "$data/courtyard.off" saved.vtp "${few[@]}" --error-points 0 --save-transport courtyard.difusa
relight_courtyard() { "$bin/relight" courtyard.difusa "courtyard_$1.vtp" --quiet --error-points 0 "${@:2}"; }
relight_courtyard half --scale sky=0.5
relight_courtyard sky --scale sky=0 --sky 2
relight_courtyard sun --scale sky=0 --sun 0,0.93969262078590838,0.34202014332566871,30
open_again() {
    DIFUSA_RELIGHT=$bin/relight timeout 200 pvbatch "$here/use_relight_again.py" "$scripts/difusa_relight.py" \
        saved.difusa courtyard.difusa "$1" courtyard_half.vtp courtyard_sky.vtp courtyard_sun.vtp >"$2.log" 2>&1
}
open_again "--threads 2" again && ! grep -Eiq 'warn|err\||error:|traceback' again.log ||
    { echo "FAILED: the plugin that relights, for another scene:" >&2; cat again.log >&2; exit 1; }
if open_again "--output-spacing '0.1" none ||
    ! grep -q "difusa: the property Options, .*: no closing quotation" none.log; then
    echo "FAILED: options with an open quotation mark:" >&2
    cat none.log >&2
    exit 1
fi
# What is not there is refused with what is.
if pvbatch "$scripts/show_bake.py" box.vtp none.png --array nothing >none.log 2>&1 || [ -e none.png ] ||
    ! grep -q "has no point array nothing; it has .*radiosity_weighted" none.log; then
    echo "FAILED: an array that is not there:" >&2
    cat none.log >&2
    exit 1
fi

cat >quality.mlx <<'FILTER'
<!DOCTYPE FilterScript>
<FilterScript><filter name="Per Vertex Quality Stat"/><filter name="Per Vertex Quality Histogram">
<Param type="RichFloat" name="HistMin" value="0"/><Param type="RichFloat" name="HistMax" value="1"/>
<Param type="RichInt" name="binNum" value="8"/><Param type="RichBool" name="areaWeighted" value="false"/>
</filter></FilterScript>
FILTER
timeout 100 meshlabserver -i box.ply -s quality.mlx -o meshlab.ply -m vc vn vq >meshlab.log 2>&1 ||
    { echo "FAILED: MeshLab:" >&2; cat meshlab.log >&2; exit 1; }

python=/usr/bin/python3
"$python" "$here/checks.py" "$out"
