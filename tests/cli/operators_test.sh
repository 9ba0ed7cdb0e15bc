# Rendering operators against the iteration.
. "$(dirname "$0")/lib.sh"

expect_exit 0 "$bake" "$box" box.ply $small --error-points 0 --save-transport box.difusa

expect_exit 0 "$relight" box.difusa --operator-table o.csv --operator dense --operator low-rank:rank=8 \
    --operator neumann:bounces=40
expect_text o.csv 'operator,light,points,stated_error,error,prepare_seconds,seconds,iteration_seconds,bytes' \
    '"low-rank:rank=8,bounces=1,more=16",' '"neumann:bounces=40",'
expect_text stdout "dense, " "written: o.csv" "low-rank:rank=8,bounces=1,more=16, "
# The last fields of a line from the right, because choices have commas of their own.
awk -F, 'FNR > 1 { stated = $(NF - 5); error = $(NF - 4) }
         FNR > 1 && /^"dense"/ && !(error < 1e-9 && stated < 1e-9) { bad = 1 }
         FNR > 1 && /^"low-rank/ && !(error > 0 && error <= stated && $NF > 0) { bad = 1 }
         FNR > 1 && /^"neumann/ && !(error < 1e-6 && stated < 1e-6 && $NF == 0) { bad = 1 }
         END { exit bad || FNR != 4 }' o.csv || fail "operators are not what they state: $(cat o.csv)"

# Without light that reaches anything there is nothing to compare.
light=$(sed -n '2s/^"dense","\([^"]*\)".*/\1/p' o.csv)
expect_refusal 1 "nothing is lit" "$relight" box.difusa --operator-table p.csv --operator dense --scale "$light=0" --sun 0,0,1,1

# Refused, without a trace.
usage() { # usage TEXT ARGUMENT...
    local text=$1
    shift
    expect_refusal 1 "$text" "$relight" "$@"
}
usage "go together" box.difusa out.ply --operator dense
usage "go together" box.difusa --operator-table p.csv
usage "no field is written: omit it" box.difusa out.ply --operator-table p.csv --operator dense
usage "did you mean low-rank" box.difusa --operator-table p.csv --operator low-rnk:rank=3
usage "choose a lower rank, or dense" box.difusa --operator-table p.csv --operator low-rank:rank=100000
usage "would overwrite" box.difusa --operator-table box.difusa --operator dense
usage "has no effect on rendering operators" box.difusa --operator-table p.csv --operator dense --output-spacing 2
usage "cannot be combined" box.difusa --sun-path 48,11,2026-06-21 --operator-table p.csv --operator dense
