#!/usr/bin/env bash
# Builds difusa and runs every test and check. On a bare Debian 12 it first installs the packages that are missing
# (as root or through sudo). Safe to run again, and quick then: only what has changed is built and checked anew.
usage="usage: tests/run.sh [OPTION]...
    --quick           release build and its tests only: no format, lint, fuzz or sanitizer checks
    --no-format       without clang-format
    --no-tidy         without clang-tidy
    --no-sanitize     without the tests under AddressSanitizer and UndefinedBehaviorSanitizer
    --no-fuzz         without the fuzz targets
    --fuzz-seconds N  time for each fuzz target (20)
    --build-dir DIR   build in DIR/test, DIR/sanitize and DIR/fuzz (build)
    --jobs N          parallel jobs (all processors)
    --help            this text"
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build=$root/build
jobs=$(nproc)
fuzz_seconds=20
format=yes tidy=yes sanitize=yes fuzz=yes

while [ $# -gt 0 ]; do
    case $1 in
    --quick) format=no tidy=no sanitize=no fuzz=no ;;
    --no-format) format=no ;;
    --no-tidy) tidy=no ;;
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

# A step's heading, with the minutes and seconds since the start.
step() { printf '\n== [%d:%02d] %s\n' $((SECONDS / 60)) $((SECONDS % 60)) "$*"; }

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
    printf '%s\n' "${summary[@]}"
    echo
    echo "$passed passed, $failed failed"
    exit $((failed > 0))
}

# build SOURCE DIRECTORY OPTION...: configures and builds everything there; ends the run if that fails.
build() {
    local source=$1 directory=$2
    shift 2
    mkdir -p "$directory"
    if cmake -S "$source" -B "$directory" -G Ninja "${launcher[@]}" "$@" \
        >"$directory/configure.log" 2>&1; then
        if cmake --build "$directory" -j "$jobs"; then
            return
        fi
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
    rm -f "$junit"
    ctest --test-dir "$directory" -j "$jobs" --output-on-failure --progress --output-junit "$junit" "$@" || true
    if [ ! -s "$junit" ]; then
        count "$name" 0 1 " (ctest did not end)"
        return
    fi
    local tests failures skipped
    tests=$(attribute tests "$junit") failures=$(attribute failures "$junit")
    skipped=$(($(attribute skipped "$junit") + $(attribute disabled "$junit")))
    if [ "$tests" -eq 0 ]; then
        count "$name" 0 1 " (no test was found)"
        return
    fi
    count "$name" $((tests - failures - skipped)) "$failures" "$([ "$skipped" -eq 0 ] || echo ", $skipped skipped")"
}

check_format() {
    find "$root"/{lib,plugins,apps,data,tests} \( -name '*.h' -o -name '*.cpp' \) -print0 |
        xargs -0 -n 20 -P "$jobs" clang-format-14 --dry-run -Werror
}

# lint STAMP_DIRECTORY COMPILE_COMMANDS_DIRECTORY FILE: clang-tidy, unless nothing changed since it last passed.
lint() {
    local stamp=$1/${3#"$root"/}.passed
    if [ -e "$stamp" ] && [ -z "$(find "$3" "$root/.clang-tidy" "$root"/{lib,plugins,apps} -newer "$stamp" \
        \( -path "$3" -o -name .clang-tidy -o -name '*.h' \) -print -quit)" ]; then
        return
    fi
    local output
    # clang does not know GCC's warning options; those it does know are the compiler's business.
    if output=$(clang-tidy-14 --quiet -p "$2" --extra-arg=-w "$3" 2>&1); then
        mkdir -p "$(dirname "$stamp")"
        touch "$stamp"
    else
        echo "clang-tidy: $3"
        echo "$output"
        return 1
    fi
}
export -f lint

check_tidy() {
    export root
    # The heaviest (those that include CGAL, VTK or OpenMesh) first, so that no core idles at the end.
    { grep -lE '#include <(CGAL|OpenMesh|vtk)' -r "$root"/{lib,plugins,apps} --include='*.cpp' || true
      grep -LE '#include <(CGAL|OpenMesh|vtk)' -r "$root"/{lib,plugins,apps} --include='*.cpp' || true; } |
        xargs -d '\n' -n 1 -P "$jobs" bash -c 'lint "$@"' lint "$build/test/tidy" "$build/test"
}

# shellcheck source=apps/install_packages.sh
. "$root/apps/install_packages.sh"
install_packages "${build_packages[@]}" "${test_packages[@]}"

launcher=()
if command -v ccache >/dev/null; then
    launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
fi

with_clang=(-DCMAKE_C_COMPILER=clang-14 -DCMAKE_CXX_COMPILER=clang++-14)

step "Build (release)"
build "$root" "$build/test" -DCMAKE_BUILD_TYPE=Release -DDIFUSA_WARNINGS_AS_ERRORS=ON
step "Tests (release)"
run_ctest "tests (release)" "$build/test"

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
    build "$root" "$build/sanitize" "${with_clang[@]}" -DCMAKE_BUILD_TYPE=Debug -DCMAKE_CXX_FLAGS_DEBUG="-O1 -g1" \
        -DDIFUSA_WARNINGS_AS_ERRORS=ON -DDIFUSA_SANITIZE=address,undefined
    step "Tests (under the sanitizers)"
    # "slow" are those that take minutes when instrumented and reach no code that the others do not.
    run_ctest "tests (under the sanitizers)" "$build/sanitize" --label-exclude slow
fi
if [ $fuzz = yes ]; then
    step "Fuzz targets"
    build "$root/tests/fuzz" "$build/fuzz" "${with_clang[@]}"
    check "fuzz targets" "$root/tests/fuzz/run.sh" "$fuzz_seconds" "$build/fuzz"
fi
finish
