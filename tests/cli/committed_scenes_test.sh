# The scenes kept in data/ are those their generator makes, all of them and nothing else.
set -eu
"$DIFUSA_BIN/generate_scenes" all
for file in *; do
    cmp "$file" "$DIFUSA_DATA/$file"
done
for file in "$DIFUSA_DATA"/*.obj "$DIFUSA_DATA"/*.mtl "$DIFUSA_DATA"/*.off "$DIFUSA_DATA"/*.ply \
    "$DIFUSA_DATA"/*.json; do
    if [ ! -e "$(basename "$file")" ]; then
        echo "$file: generate_scenes does not make it" >&2
        exit 1
    fi
done

# A mistake ends with a message and the exit code of its kind.
refused() {
    local expected=$1 code=0
    shift
    "$DIFUSA_BIN/generate_scenes" "$@" 2>message || code=$?
    if [ "$code" != "$expected" ] || [ ! -s message ]; then
        echo "generate_scenes $*: exit $code, expected $expected: $(cat message)" >&2
        exit 1
    fi
}
refused 1
refused 1 no_such_scene
refused 1 room_with_balls many
refused 1 room_with_balls 10
for name in hall bowl all; do
    refused 1 $name 10
    grep -q "10: only engine and room_with_balls take a number of triangles" message
done
"$DIFUSA_BIN/generate_scenes" --help >help 2>message
grep -q "^usage: generate_scenes" help && [ ! -s message ]
touch file
refused 2 --directory file/below bowl
