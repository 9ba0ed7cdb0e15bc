#!/usr/bin/env bash
# From a bare Debian 12 to a baked scene: installs missing packages (as root or through sudo), builds difusa in
# build/quickstart, bakes data/cornell_box.obj, and says what to open. Safe to rerun; later runs are quick.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build=$root/build/quickstart
bake=$build/bin/bake_radiosity
scene=$root/data/cornell_box.obj

# shellcheck source=apps/install_packages.sh
. "$root/apps/install_packages.sh"
install_packages "${build_packages[@]}"

launcher=()
if command -v ccache >/dev/null; then
    launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
fi
log=$build/configure.log
mkdir -p "$build"
if ! cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DDIFUSA_BUILD_TESTS=OFF "${launcher[@]}" \
    >"$log" 2>&1; then
    cat "$log" >&2
    echo "error: difusa could not be configured" >&2
    exit 5
fi
echo "Building in $build ..."
cmake --build "$build"

echo
echo "Baking $scene ..."
"$bake" "$scene" "$build/cornell_box.vtp"
"$bake" "$scene" "$build/cornell_box.ply" --quiet

cat <<END

To look at the result:
    paraview $build/cornell_box.vtp
        press Apply, colour by display_rgb and switch "Map Scalars" off; or colour by
        radiosity_weighted, one number (of R, G and B, ParaView shows the magnitude, which means nothing)
    meshlab $build/cornell_box.ply
To bake a mesh of your own:
    $bake mesh.off out.vtp
    $bake --help
END
