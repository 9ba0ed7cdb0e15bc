# What the scripts of this directory share. Each runs in an empty directory of its own; the first expectation that does
# not hold ends it.
set -u

bake=$DIFUSA_BIN/bake_radiosity
relight=$DIFUSA_BIN/relight
box=$DIFUSA_DATA/cornell_box.obj
small="--sites 60 --rays 16" # where only the way through the program matters

# Whether the programs are built with a sanitizer: ten times as slow, and their memory is not their own. Memory errors do
# not depend on the number of triangles, sites or rays, so the scripts that take longest use fewer of them then.
sanitized=no
if grep -q -e __asan_init -e __tsan_init "$bake"; then
    sanitized=yes
fi

fail() {
    echo "FAILED: $*" >&2
    if [ -s stdout ] || [ -s stderr ]; then
        echo "--- its standard output and error:" >&2
        tail -n 40 stdout stderr >&2
    fi
    exit 1
}

# expect_exit CODE COMMAND...: runs it, its output goes to the files stdout and stderr.
expect_exit() {
    local expected=$1 code=0
    shift
    "$@" >stdout 2>stderr </dev/null || code=$?
    [ "$code" = "$expected" ] || fail "exit $code, expected $expected: $*"
}

# expect_text FILE TEXT...: each of the texts occurs in the file.
expect_text() {
    local file=$1 text
    shift
    for text in "$@"; do
        grep -qF -e "$text" "$file" || fail "\`$text\` is not in $file: $(head -c 2000 "$file")"
    done
}

expect_no_text() {
    if grep -qF -e "$2" "$1"; then
        fail "\`$2\` is in $1"
    fi
}

# expect_refusal CODE TEXT PROGRAM ARGUMENT...: ends with the code and one line on standard error that names a program
# and holds the text, after lines of progress at most; leaves no file that was not there.
expect_refusal() {
    local code=$1 text=$2
    shift 2
    ls -A . >before
    : >stdout
    : >stderr
    expect_exit "$code" "$@"
    ls -A . >after
    cmp -s before after || fail "the files have changed: $(diff before after)"
    [ ! -s stdout ] || fail "standard output is not empty: $*"
    tail -n 1 stderr >message
    grep -qE '^(bake_radiosity|compare_fields|form_factors|inspect_basis|measure_accuracy|relight|render_view): ' message ||
        fail "the message does not name its program: $(cat message)"
    expect_text message "$text"
}

# The number (or word) of the first entry of this name in a report.
entry() {
    sed -n "s/^ *\"$2\": *\"\{0,1\}\([^\",]*\)\"\{0,1\},\{0,1\}\$/\1/p" "$1" | head -n 1
}

# A binary PLY that was baked, without the comments that tell times and file names: what must not differ.
without_comments() {
    sed -e '1,/^end_header/{/^comment/d}' "$1"
}

expect_same_field() {
    without_comments "$1" >first.stripped
    without_comments "$2" >second.stripped
    cmp first.stripped second.stripped || fail "$1 and $2 are not the same"
}

expect_other_field() {
    without_comments "$1" >first.stripped
    without_comments "$2" >second.stripped
    if cmp -s first.stripped second.stripped; then
        fail "$1 and $2 are the same"
    fi
}

touch before after message stdout stderr

# closed_cube: the unit cube, all of whose faces look inward, as an OFF file.
closed_cube() {
    cat <<'CUBE'
OFF
8 6 0
0 0 0
1 0 0
1 1 0
0 1 0
0 0 1
1 0 1
1 1 1
0 1 1
4 0 1 2 3
4 4 7 6 5
4 0 4 5 1
4 3 2 6 7
4 0 3 7 4
4 1 5 6 2
CUBE
}
