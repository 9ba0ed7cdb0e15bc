# Where the system provides no threads, the caller's own does all of the work: the same result, and a note.
. "$(dirname "$0")/lib.sh"

# unthreaded COMMAND...: as a user who may not start anything.
unthreaded() {
    # Looking for leaks, in a sanitized build, takes a thread as well.
    local -x ASAN_OPTIONS=${ASAN_OPTIONS:+$ASAN_OPTIONS:}detect_leaks=0
    if [ "$(id -u)" = 0 ]; then
        setpriv --reuid=65534 --regid=65534 --clear-groups bash -c 'ulimit -u 1 && exec "$@"' bash "$@"
    else
        (
            ulimit -u 1
            exec "$@"
        )
    fi
}
chmod 777 . stdout stderr
if unthreaded sh -c '(true) && true' 2>stderr || ! unthreaded true 2>stderr; then
    echo "skipped: the number of processes cannot be limited here"
    exit 77 # SKIP_RETURN_CODE
fi

for engine in cgal auto; do
    for out in field.vtp field.ply; do
        expect_exit 0 "$bake" "$box" with_$out $small --visibility $engine --threads 4
        expect_no_text stdout "fewer threads"
        expect_exit 0 unthreaded "$bake" "$box" $out $small --visibility $engine --threads 4 --sites-output sites.vtp
        [ "$(grep -c "note: the system provides fewer threads" stdout)" = 1 ] || fail "no note, or several"
    done
    expect_same_field with_field.ply field.ply
    expect_exit 0 unthreaded "$DIFUSA_BIN/compare_fields" field.vtp with_field.vtp error.vtp --threads 4
    expect_text stdout "radiosity"
done
expect_exit 0 unthreaded "$DIFUSA_BIN/render_view" "$box" picture.png $small --size 32 24 --threads 4
expect_exit 0 unthreaded "$DIFUSA_BIN/inspect_basis" "$box" basis.vtp --sites 60 --threads 4
