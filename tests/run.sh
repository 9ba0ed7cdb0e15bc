#!/usr/bin/env bash
# Builds difusa and runs every test and check. On a bare Debian 12 it first installs the packages that are missing
# (as root or through sudo). Safe to run again, and quick then: only what has changed is built and checked anew.
# At the end it prints what was slowest, how long each step took, and last how many tests passed and failed.
usage="usage: tests/run.sh [OPTION]...
    --quick           release build and its tests only: no format, lint, viewer, fuzz or sanitizer checks
    --no-format       without clang-format
    --no-tidy         without clang-tidy
    --no-viewers      without opening what is baked in ParaView and MeshLab, and without installing them
    --no-sanitize     without the tests under AddressSanitizer and UndefinedBehaviorSanitizer
    --no-fuzz         without the fuzz targets
    --fuzz-seconds N  time for each fuzz target (5)
    --build-dir DIR   build in DIR/test, DIR/sanitize and DIR/fuzz; pictures are kept in DIR/viewers (build)
    --jobs N          parallel jobs (all processors)
    --help            this text
The end says what took longest to build and to test, how long each step took, and in the last line what passed and failed."
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build=$root/build
jobs=$(nproc)
fuzz_seconds=5
format=yes tidy=yes viewers=yes sanitize=yes fuzz=yes

while [ $# -gt 0 ]; do
    case $1 in
    --quick) format=no tidy=no viewers=no sanitize=no fuzz=no ;;
    --no-format) format=no ;;
    --no-tidy) tidy=no ;;
    --no-viewers) viewers=no ;;
    --no-sanitize) sanitize=no ;;
    --no-fuzz) fuzz=no ;;
    --fuzz-seconds | --build-dir | --jobs)
        [ $# -gt 1 ] || { echo "error: $1 needs a value" >&2; exit 1; }
        case $1 in
        --fuzz-seconds) fuzz_seconds=$2 ;;
        --build-dir) build=$(mkdir -p "$2" && cd "$2" && pwd) ;;
        --jobs) jobs=$2 ;;
        esac
        shift ;;
    --help) echo "$usage"; exit 0 ;;
    *) echo "error: unknown option $1" >&2; echo "$usage" >&2; exit 1 ;;
    esac
    shift
done

passed=0 failed=0
summary=()
times=() slowest=()

# duration NAME SECONDS: a line of the table of times.
duration() { printf '%-64s %4d:%02d' "$1" $(($2 / 60)) $(($2 % 60)); }

# A step's heading, with the minutes and seconds since the start. Ends the step before it, and notes its time.
current_step='' step_began=0
step() {
    [ -z "$current_step" ] || times+=("$(duration "$current_step" $((SECONDS - step_began)))")
    current_step=$* step_began=$SECONDS
    printf '\n== [%d:%02d] %s\n' $((SECONDS / 60)) $((SECONDS % 60)) "$*"
}

# slowest_of NAME: from lines "SECONDS WHAT", the five that took longest, if they took a second.
slowest_of() {
    local lines
    lines=$(sort -rn | awk 'NR <= 5 && $1 >= 1 { printf "    %8.1f s ", $1; $1 = ""; sub(/ # GetParam.*/, ""); print }')
    [ -z "$lines" ] || slowest+=("$1:" "$lines")
}

# count NAME PASSED FAILED [NOTE]: adds to the totals.
count() {
    passed=$((passed + $2)) failed=$((failed + $3))
    summary+=("$(printf '%-44s %4d passed, %d failed%s' "$1" "$2" "$3" "${4:-}")")
}

# check NAME COMMAND...: one more test, passed if the command succeeds.
check() {
    local name=$1
    shift
    if "$@"; then count "$name" 1 0; else count "$name" 0 1; fi
}

# finish: the summary; its last line alone says how many passed and failed.
finish() {
    step "Summary"
    [ ${#slowest[@]} -eq 0 ] || printf '%s\n' "${slowest[@]}" ''
    printf '%s\n' "${times[@]}" "$(duration "all (minutes:seconds)" $SECONDS)" ''
    printf '%s\n' "${summary[@]}"
    echo
    echo "$passed passed, $failed failed"
    exit $((failed > 0))
}

# build SOURCE DIRECTORY OPTION...: configures and builds everything there; ends the run if that fails.
build() {
    local source=$1 directory=$2 began built=no
    shift 2
    mkdir -p "$directory"
    began=$directory/began
    touch "$began"
    if cmake -S "$source" -B "$directory" -G Ninja "${launcher[@]}" "$@" \
        >"$directory/configure.log" 2>&1; then
        if cmake --build "$directory" -j "$jobs"; then
            built=yes
        fi
        # Start and end in milliseconds, and the file made.
        [ ! -s "$directory/.ninja_log" ] || slowest_of "slowest to build in $directory" < <(
            cd "$directory" && awk -F '\t' '!/^#/ { time[$4] = ($2 - $1) / 1000 }
                                           END { for (file in time) print time[file], file }' .ninja_log |
                sort -rn | head -n 100 |
                while read -r time file; do
                    [ ! "$file" -nt began ] || echo "$time $file"
                done)
        [ $built = no ] || return 0
    else
        cat "$directory/configure.log" >&2
    fi
    count "build in $directory" 0 1
    finish
}

# attribute NAME FILE: a number from the first element of a JUnit file of ctest, which has one attribute on a line.
attribute() {
    local value
    value=$(sed -n "s/^[[:space:]]*$1=\"\([0-9]*\)\".*/\1/p" "$2" | head -n 1)
    echo "${value:-0}"
}

# run_ctest NAME DIRECTORY OPTION...
run_ctest() {
    local name=$1 directory=$2 junit=$2/junit.xml
    shift 2
    rm -rf "$junit" "$directory/tests/shards"
    ctest --test-dir "$directory" -j "$jobs" --output-on-failure --progress --output-junit "$junit" "$@" || true
    if [ ! -s "$junit" ]; then
        count "$name" 0 1 " (ctest did not end)"
        return
    fi
    local tests failures skipped
    tests=$(attribute tests "$junit") failures=$(attribute failures "$junit")
    skipped=$(($(attribute skipped "$junit") + $(attribute disabled "$junit")))
    # What ctest takes for one test each are many, unless they ended before they could say so.
    local shard number
    for shard in "$directory"/tests/shards/*.xml; do
        [ -s "$shard" ] || continue
        number=$(sed -n 's/^<testsuites tests="\([0-9]*\)".*/\1/p' "$shard")
        tests=$((tests + number - 1))
        number=$(sed -n 's/^<testsuites .* failures="\([0-9]*\)".*/\1/p' "$shard")
        failures=$((failures + number - (number > 0)))
        skipped=$((skipped + $(grep -c 'result="skipped"' "$shard" || true)))
    done
    if [ "$tests" -eq 0 ]; then
        count "$name" 0 1 " (no test was found)"
        return
    fi
    slowest_of "slowest of the $name" < <(
        sed -nE 's/^[[:space:]]*<testcase name="([^"]*)".* time="([0-9.]*)".*/\2 \1/p' "$junit" |
            grep -v ' difusa_tests\.[0-9]*$' || true
        # A shard is no test: those in it.
        for shard in "$directory"/tests/shards/*.xml; do
            [ ! -s "$shard" ] ||
                sed -nE 's/^[[:space:]]*<testcase name="([^"]*)".* time="([0-9.]*)".* classname="([^"]*)".*/\2 \3.\1/p' \
                    "$shard"
        done)
    count "$name" $((tests - failures - skipped)) "$failures" "$([ "$skipped" -eq 0 ] || echo ", $skipped skipped")"
}

check_format() {
    find "$root"/{lib,plugins,apps,data,tests} \( -name '*.h' -o -name '*.cpp' \) -print0 |
        xargs -0 -n 20 -P "$jobs" clang-format-14 --dry-run -Werror
}

# lint STAMPS OPTIONS FILE...: clang-tidy for all these files together, because nearly all of its time goes into the
# headers they share. If it complains, those it complains of and the others for themselves, or each half if that is all
# of them or none. It also complains if two of them use one name, which is said, because it takes long.
lint() {
    local stamps=$1 options=$2 file entry output
    shift 2
    if [ $# -eq 1 ]; then
        # clang does not know GCC's warning options; those it does know are the compiler's business.
        if output=$(clang-tidy-14 --quiet -p "$stamps" --extra-arg=-w "$1" 2>&1); then
            mkdir -p "$(dirname "$stamps/$1")"
            touch "$stamps/$1.passed"
            return
        fi
        printf 'clang-tidy: %s\n%s\n' "$1" "$output"
        return 1
    fi
    local together
    together=$(mktemp -d "$stamps/together.XXXXXX")
    for file in "$@"; do
        entry=${file//[^a-z]/_}
        printf '#undef %s\n#define %s %s\n' main main "main$entry" difusa_plugin_tag difusa_plugin_tag "tag$entry" \
            difusa_plugin_entry difusa_plugin_entry "entry$entry"
        printf '#include "%s" // NOLINT\n' "$file"
    done >"$together/files.cpp"
    printf '[{"directory": "%s", "command": "c++ %s -c %s", "file": "%s"}]\n' \
        "$stamps" "$options" "$together/files.cpp" "$together/files.cpp" >"$together/compile_commands.json"
    if clang-tidy-14 --quiet -p "$together" --config-file="$root/.clang-tidy" --extra-arg=-w \
        --header-filter='/(lib/difusa|plugins|apps)/' "$together/files.cpp" >"$together/output" 2>&1; then
        for file in "$@"; do
            mkdir -p "$(dirname "$stamps/$file")"
            touch "$stamps/$file.passed"
        done
        rm -r "$together"
        return
    fi
    printf 'clang-tidy: %d files again in parts, because of: %s\n' $# \
        "$(grep -m 1 '^/.*clang-diagnostic-error' "$together/output" || grep -F -m 1 ' error: ' "$together/output")"
    local some=() others=() half=$(($# / 2)) result=0
    for file in "$@"; do
        if grep -F ' error: ' "$together/output" | grep -qF "$file:"; then
            some+=("$file")
        else
            others+=("$file")
        fi
    done
    rm -r "$together"
    if [ ${#some[@]} -eq 0 ] || [ ${#others[@]} -eq 0 ]; then
        some=("${@:1:half}") others=("${@:half+1}")
    fi
    lint "$stamps" "$options" "${some[@]}" || result=1
    lint "$stamps" "$options" "${others[@]}" || result=1
    return $result
}
export -f lint

# sources_and_options BUILD: each source of programs, library and plugins after the options that serve for all of its
# language version: what any of them defines and where any of them looks for headers.
sources_and_options() {
    local folder
    # What needs CGAL first, so that its headers are read for one pile only.
    for folder in plugins lib/difusa/mesh lib apps; do
        sed -nE 's/^ *"command": "(.*) -o [^ ]* -c (.*)",?$/\2 \1/p' "$1/compile_commands.json" |
            grep "^$root/$folder/" | sort -u -k 1,1
    done |
        awk 'listed[$1]++ { next }
             {
                 version = ""
                 for (i = 2; i <= NF; i++) {
                     if ($i ~ /^-std=/) {
                         version = $i
                     }
                 }
                 file[++n] = $1
                 versions[n] = version
                 for (i = 2; i <= NF; i++) {
                     word = $i == "-isystem" ? $i " " $(++i) : $i
                     if (word ~ /^-([ID]|isystem)/ && word !~ /_EXPORTS$/ && !((version, word) in known)) {
                         known[version, word] = 1
                         options[version] = options[version] " " word
                     }
                 }
             }
             END { for (i = 1; i <= n; i++) { print versions[i] options[versions[i]] "\t" file[i] } }' |
        sort -s -t '	' -k 1,1
}

check_tidy() {
    export root
    local stamps=$build/tidy newest_header
    mkdir -p "$stamps"
    # How each file is compiled by itself.
    if ! cmake -S "$root" -B "$stamps" -G Ninja -DCMAKE_BUILD_TYPE=Release -DDIFUSA_UNITY=OFF \
        -DDIFUSA_BUILD_TESTS=OFF >"$stamps/configure.log" 2>&1; then
        cat "$stamps/configure.log" >&2
        return 1
    fi
    newest_header=$(find "$root/.clang-tidy" "$root"/{lib,plugins,apps} \( -name .clang-tidy -o -name '*.h' \) \
        -printf '%T@ %p\n' | sort -n | tail -n 1 | cut -d ' ' -f 2-)
    sources_and_options "$stamps" |
        while IFS='	' read -r options file; do
            stamp=$stamps/$file.passed
            # Unless nothing changed since it last passed.
            if [ ! "$stamp" -nt "$file" ] || [ ! "$stamp" -nt "$newest_header" ]; then
                printf '%s\t%s\n' "$options" "$file"
            fi
        done |
        # A pile of neighbours for each processor, unless they would be small or very large.
        awk -F '\t' -v jobs="$jobs" 'function deal(  piles, i) {
                         piles = n < 20 ? (n > 0) : jobs * int((n + 300 * jobs - 1) / (300 * jobs))
                         for (i = 0; i < n; i++) {
                             if (i == 0 || int(i * piles / n) != int((i - 1) * piles / n)) {
                                 printf "%s%s", (i == 0 ? "" : "\n"), options
                             }
                             printf "\t%s", file[i]
                         }
                         printf "%s", (n == 0 ? "" : "\n")
                         n = 0
                     }
                     $1 != options { deal() }
                     { file[n++] = $2; options = $1 }
                     END { deal() }' |
        xargs -r -d '\n' -n 1 -P "$jobs" bash -c \
            'set -f; IFS="	"; read -r -a words <<<"$2"; unset IFS; lint "$1" "${words[@]}"' lint "$stamps"
}

step "Packages"
# shellcheck source=apps/install_packages.sh
. "$root/apps/install_packages.sh"
install_packages "${build_packages[@]}" "${test_packages[@]}"

launcher=()
if command -v ccache >/dev/null; then
    launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
fi

with_clang=(-DCMAKE_C_COMPILER=clang-14 -DCMAKE_CXX_COMPILER=clang++-14)

# What the release build does not need is installed beside it.
later_packages=("${check_packages[@]}")
[ $viewers = no ] || later_packages+=("${viewer_packages[@]}")
mkdir -p "$build"
{
    install_packages "${later_packages[@]}"
    [ $viewers = no ] || fetch_paraview_python "$build/viewers/python"
} >"$build/packages.log" 2>&1 &
installation=$!

step "Build (release)"
build "$root" "$build/test" -DCMAKE_BUILD_TYPE=Release -DDIFUSA_WARNINGS_AS_ERRORS=ON
step "Packages for the checks"
wait $installation || { cat "$build/packages.log" >&2; exit 4; }
cat "$build/packages.log"
step "Tests (release)"
run_ctest "tests (release)" "$build/test"

if [ $viewers = yes ]; then
    step "Viewers (ParaView, MeshLab)"
    check "viewers (ParaView, MeshLab)" env PYTHONPATH="$build/viewers/python/usr/lib/python3/dist-packages" \
        "$root/tests/viewers/run.sh" "$build/test/bin" "$build/viewers"
fi
if [ $format = yes ]; then
    step "Formatting"
    check "formatting (clang-format)" check_format
fi
if [ $tidy = yes ]; then
    step "Lint"
    check "lint (clang-tidy)" check_tidy
fi
if [ $sanitize = yes ]; then
    step "Build (clang, AddressSanitizer, UndefinedBehaviorSanitizer)"
    # Without -g, which takes a sixth of the time: reports name functions, and a build with -g1 then tells their lines.
    build "$root" "$build/sanitize" "${with_clang[@]}" -DCMAKE_BUILD_TYPE=Debug -DCMAKE_CXX_FLAGS_DEBUG=-O1 \
        -DDIFUSA_WARNINGS_AS_ERRORS=ON -DDIFUSA_SANITIZE=address,undefined \
        -DDIFUSA_TEST_OBJECTS="$build/test/tests/difusa_tests.objects"
    step "Tests (under the sanitizers)"
    run_ctest "tests (under the sanitizers)" "$build/sanitize"
fi
if [ $fuzz = yes ]; then
    step "Fuzz targets"
    build "$root/tests/fuzz" "$build/fuzz" "${with_clang[@]}"
    check "fuzz targets" "$root/tests/fuzz/run.sh" "$fuzz_seconds" "$build/fuzz" "$jobs"
fi
finish
