# A wrong command line is refused before any work, with what is wrong and what is right.
. "$(dirname "$0")/lib.sh"

usage() { # usage TEXT ARGUMENT...
    local text=$1
    shift
    expect_refusal 1 "$text" "$bake" "$@"
    [ "$(wc -l <stderr)" = 1 ] || fail "more than a message: $*"
}

usage "a mesh file is expected"
usage "an output file is expected" "$box"
usage "\`third\` is one argument too many" "$box" out.vtp third
usage "a mesh file is expected" "" out.vtp
usage "--sites: is given more than once" "$box" out.vtp --sites 100 --sites 200
usage "--sites: needs a value" "$box" out.vtp --sites

# Unknown names, with the nearest known one.
usage "unknown option --ryas, did you mean --rays?" "$box" out.vtp --ryas 12
usage "unknown option --neighbors, did you mean --neighbours?" "$box" out.vtp --neighbors=12
usage "did you mean 'shepard'?" "$box" out.vtp --basis shepherd
usage "did you mean 'embree'?" "$box" out.vtp --visibility embre
usage "did you mean 'krylov'?" "$box" out.vtp --solver krilov
usage "did you mean 'gauss-seidel'?" "$box" out.vtp --solver gauss-siedel
usage "no parameter 'ambient'" "$box" out.vtp --solver southwell:ambient=no
usage "must be a number from 0.05 to 1.95" "$box" out.vtp --solver gauss-seidel:relaxation=2
usage "--stop chance: must be one of residual, change; did you mean change?" "$box" out.vtp --stop chance
for solver in gauss-seidel southwell progressive; do
    usage "--solver $solver: relaxes one unknown after the other" "$box" out.vtp --solver $solver --projection galerkin
    usage "use --solver krylov or jacobi" "$box" out.vtp --solver $solver --basis radial
done
usage "must end in .pvd" "$box" out.vtp --convergence steps.vtp
usage "two outputs have this name" "$box" steps_0003.vtp --convergence steps.pvd
usage "omit one of them" "$box" out.vtp --convergence steps.pvd --error 5%
usage "did you mean 'poisson-disk'?" "$box" out.vtp --sampler poison_disk
usage "did you mean 'low-discrepancy'?" "$box" out.vtp --directions low-discrepancies
usage "did you mean 'disc'?" "$box" out.vtp --kernel disk --transport pairwise
usage "did you mean 'disc'?" "$box" out.vtp --kernel disk
usage "omit it, or use --transport pairwise" "$box" out.vtp --kernel point
usage "did you mean gather?" "$box" out.vtp --transport gathr
usage "did you mean 'width'?" "$box" out.vtp --basis radial:widht=1
usage "no parameter 'areas'" "$box" out.vtp --transport gather:areas=integral
usage "one of gaussian, cubic" "$box" out.vtp --basis radial:profile=cubik
usage "must be a number from" "$box" out.vtp --basis shepard:k=many
usage "/nowhere" "$box" out.vtp --plugin-path /nowhere
usage "/nowhere" "$box" out.vtp --plugin-path . --plugin-path /nowhere

# Values: all kinds of bad ones for one option, and one for the others of its kind, which are parsed by the same
# function. Under the sanitizers one of a kind: the others take the same way through the program.
one_is_enough() {
    [ $sanitized = yes ]
}
for bad in abc -5 0 1e3 2.5 12x; do
    usage "--rays $bad: must be a whole number of at least 1" "$box" out.vtp "--rays=$bad"
    one_is_enough && break
done
for option in --sites --neighbours --threads; do
    usage "$option 0: must be a whole number of at least 1" "$box" out.vtp $option=0
done
usage "--rays -5: must be" "$box" out.vtp --rays -5
usage "must be at most 18446744073709551615" "$box" out.vtp --rays 99999999999999999999999
usage "--rays: must be from 1 to 16777216" "$box" out.vtp --rays 1000000000
usage "--neighbours: must be from 1 to 1000" "$box" out.vtp --neighbours 1001
usage "--threads 1025: must be at most 1024" "$box" out.vtp --threads 1025
usage "--seed -1: must be a whole number of at least 0" "$box" out.vtp --seed -1
for bad in 1 % -1% 0% nan% 1%% "1 % of it" inf%; do
    usage "--error $bad: takes a positive percentage with its sign, such as 1%" "$box" out.vtp "--error=$bad"
    one_is_enough && break
done
for bad in 4Gib GiB -4GiB 0MB nanMB "4 GiB" 4GB5 inf; do
    usage "--max-memory $bad: takes a positive size such as 500MB or 4GiB" "$box" out.vtp "--max-memory=$bad"
    one_is_enough && break
done
usage "--rays: cannot be combined with --error" "$box" out.vtp --error 1% --rays 64
usage "--quality: cannot be combined with --error" "$box" out.vtp --error 1% --quality draft
usage "--goal-samples: cannot be combined with --error" "$box" out.vtp --error 1% --goal-samples 64
usage "--max-sites: has no effect without --error" "$box" out.vtp --max-sites 1000
usage "--best-effort: has no effect without --error" "$box" out.vtp --best-effort
usage "--error-chart: has no effect without --error" "$box" out.vtp --error-chart chart.svg
usage "--error-chart chart.png: a chart is written as .svg" "$box" out.vtp --error 9% --error-chart chart.png
usage "a dry run cannot tell what --error will take" "$box" --dry-run --error 1%
usage "--max-iterations -1: must be" "$box" out.vtp --max-iterations -1
for bad in nan inf 0 -1 1e400 1e-400 "0.1 m"; do
    usage "--spacing $bad: must be a positive number" "$box" out.vtp "--spacing=$bad"
    one_is_enough && break
done
usage "--output-spacing nan: must be a positive number" "$box" out.vtp --output-spacing nan
usage "--tolerance 0: must be a positive number" "$box" out.vtp --tolerance 0
usage "--tolerance: must be above 0 and below 1" "$box" out.vtp --tolerance 1
usage "either --spacing or --sites" "$box" out.vtp --spacing 0.1 --sites 10
usage "--rays: needs a value" "$box" out.vtp --rays
for bad in , 1, 1,2 1,2,3, 1,2,3,4 1,,3 garbage -1 1,-1,1 nan inf 1e400 "1 2 3" " 1"; do
    usage "--sky $bad: takes one number, or three R,G,B" "$box" out.vtp "--sky=$bad"
    one_is_enough && break
done
usage "--reflectance 1,,3: takes one number, or three R,G,B" "$box" out.vtp --reflectance 1,,3
usage "--sky -1: takes" "$box" out.vtp --sky -1
usage "--reflectance: must be from 0 to 1" "$box" out.vtp --reflectance 0.5,1.5,0.5

# Good ones: -/_ are equal in names, numbers may be as C writes them.
expect_exit 0 "$bake" "$box" out.ply $small --sky 0.5,1e-3,.25 --quiet
expect_exit 0 "$bake" "$box" out.ply $small --basis normalized_radial:width=1.1 --sampler poisson_disk --quiet
expect_exit 0 "$bake" "$box" out.ply $small --basis radial:profile=cubic,width=1 --report report.json --quiet
expect_text report.json '"basis": "radial:width=1,profile=cubic"'
expect_exit 0 "$bake" "$box" out.ply $small --seed 18446744073709551615 --report report.json --quiet
expect_text report.json '"seed": 18446744073709551615'

# A preset chooses what is not given, and the report says so.
chosen() { # chosen ENTRY WANTED OPTION...
    local name=$1 wanted=$2
    shift 2
    expect_exit 0 "$bake" "$box" --dry-run --quiet --report preset.json "$@"
    [ "$(entry preset.json "$name")" = "$wanted" ] || fail "$name is $(entry preset.json "$name"), not $wanted: $*"
}
chosen rays 128 --quality draft
chosen sites 1000 --quality draft
chosen rays 64 --quality draft --rays 64
chosen sites null --quality draft --spacing 0.05
chosen final_gather 256 --quality final --sites 500 --rays 16
chosen quality final --quality final --sites 500 --rays 16
chosen rays 512 --quality normal
chosen quality null
expect_refusal 1 "--quality best: must be draft, normal or final" "$bake" "$box" out.vtp --quality best
