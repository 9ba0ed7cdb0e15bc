# Installs difusa into a scratch prefix, moves it elsewhere, and lets a stranger's project use it: its own plugin and
# program are built against the installed package, and the installed bake_radiosity bakes with the plugin, beside
# modules that must be refused. Run in an empty directory; the environment is set by tests/CMakeLists.txt.
set -euo pipefail

fail() {
    echo "FAILED: $*" >&2
    exit 1
}

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
scratch=$PWD
unset DIFUSA_PLUGIN_PATH LD_LIBRARY_PATH

echo "== Install, and move the installed tree"
"$CMAKE" --install "$DIFUSA_BUILD" --prefix "$scratch/installed" >install.log || { cat install.log; fail "install"; }
mv installed moved
prefix=$scratch/moved
bake=$prefix/bin/bake_radiosity

echo "== The public headers need nothing but Eigen"
(cd "$prefix/include" && find difusa -name '*.h' | sort | sed 's/.*/#include <&>/') >all_headers.cpp
"$CXX" -std=c++20 -M -I "$prefix/include" -I "$EIGEN_INCLUDE" all_headers.cpp >dependencies.txt
if foreign=$(tr ' ' '\n' <dependencies.txt | grep -E '/(CGAL|OpenMesh|vtk[^/]*|embree[0-9]*|nlohmann|CLI)/|nanoflann'); then
    fail "public headers include" $foreign
fi

echo "== Configure and build the stranger's project"
"$CMAKE" -S "$here" -B build -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER="$CXX" \
    -DCMAKE_CXX_FLAGS="-Wall -Wextra -Wpedantic -Werror" -DCMAKE_PREFIX_PATH="$prefix"
"$CMAKE" --build build
plugins=$scratch/plugins
mkdir "$plugins"
cp build/wendland.so "$plugins"

echo "== Its programs"
build/use_library "$plugins"
build/bake_in_memory

echo "== Bad modules beside it"
export DIFUSA_TEST_MARKER=$scratch/marker
cp "$DIFUSA_TEST_PLUGINS"/{wrong_version,no_entry,throwing_entry}.so "$plugins"
echo "this is no shared object" >"$plugins/text.so"
head -c 5000 build/wendland.so >"$plugins/truncated.so"

echo "== List"
"$bake" --plugin-path "$plugins" --list-plugins >list.txt || fail "--list-plugins ended with $?"
cat list.txt
grep -q wendland list.txt || fail "the stranger's plugin is not listed"
grep -q shepard list.txt || fail "the installed plugins are not listed"
for bad in wrong_version no_entry throwing_entry text truncated; do
    grep -q "$bad.so" list.txt || fail "$bad.so is not listed as refused"
done

echo "== Bake with the stranger's basis"
"$bake" "$DIFUSA_DATA/cornell_box.obj" out.vtp --plugin-path "$plugins" --basis wendland:width=1.2 --sites 300 \
    --rays 64 --report report.json || fail "bake_radiosity ended with $?"
[ -s out.vtp ] || fail "no output"
grep -q 'wendland:width=1.2' report.json || fail "the report does not name the basis"
[ ! -e marker ] || fail "code of a refused module ran"

echo "== An unknown basis is refused, with the reason if its module was"
if "$bake" "$DIFUSA_DATA/cornell_box.obj" x.vtp --plugin-path "$plugins" --basis wendlnad 2>error.txt; then
    fail "an unknown basis was accepted"
fi
grep -q "'wendland'" error.txt || fail "the nearest name is not suggested: $(cat error.txt)"
echo "passed"
