# shellcheck shell=bash disable=SC2034
# Sourced by apps/quickstart.sh and tests/run.sh: the Debian 12 packages difusa is built with, in one place, and a
# function that installs the missing ones.

# To build and run the programs.
build_packages=(
    g++ cmake ninja-build
    libcgal-dev libeigen3-dev libopenmesh-dev libvtk9-dev libembree-dev
    libpng-dev libjpeg-dev libtiff-dev libhdf5-dev zlib1g-dev
    libcli11-dev libnanoflann-dev nlohmann-json3-dev
)

# In addition, to build and run the tests.
test_packages=(libgtest-dev libgmock-dev libbenchmark-dev)

# In addition, for the checks; formatting and lint depend on the version of clang.
check_packages=(
    clang-14 clang-format-14 clang-tidy-14 libclang-rt-14-dev
)

# To open bakes in ParaView and MeshLab without a screen. ParaView's Python modules: see fetch_paraview_python.
viewer_packages=(paraview xvfb meshlab python3)

# missing_packages PACKAGE...: those not installed, separated by spaces.
missing_packages() {
    local package missing=()
    for package in "$@"; do
        if [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" != installed ]; then
            missing+=("$package")
        fi
    done
    echo "${missing[*]}"
}

# install_packages PACKAGE...: installs what is missing, as root or through sudo, and prints its names; if it cannot, it
# ends the script with instructions. With nothing missing it needs neither root nor the network.
install_packages() {
    if ! command -v dpkg-query >/dev/null; then
        echo "This is not Debian: make sure that the equivalents of these packages are installed:"
        echo "    $*"
        return
    fi
    local missing as_root=()
    missing=$(missing_packages "$@")
    if [ -z "$missing" ]; then
        return
    fi
    echo "Missing packages: $missing"
    if [ "$(id -u)" -ne 0 ]; then
        if ! command -v sudo >/dev/null; then
            echo "error: they can be installed by root only, and there is no sudo. As root, run" >&2
            echo "    apt-get update && apt-get install --no-install-recommends $missing" >&2
            exit 4
        fi
        as_root=(sudo)
        # If nobody can type a password, sudo fails at once instead of waiting for one.
        [ -t 0 ] || as_root=(sudo -n)
    fi
    as_root+=(env DEBIAN_FRONTEND=noninteractive)
    echo "Installing them (this may take some minutes; the log is printed if it fails) ..."
    local log
    log=$(mktemp)
    # shellcheck disable=SC2086 # $missing is a list of words
    if ! { "${as_root[@]}" apt-get -q update &&
           "${as_root[@]}" apt-get -q -y -o DPkg::Lock::Timeout=600 install --no-install-recommends \
               --no-remove $missing; } \
         >"$log" 2>&1; then
        tail -n 40 "$log" >&2
        rm -f "$log"
        echo "error: apt-get could not install: $missing" >&2
        exit 4
    fi
    rm -f "$log"
}

# fetch_paraview_python DIRECTORY: unpacks ParaView's Python modules there (in usr/lib/python3/dist-packages), unless
# the installed version is there already. Their package cannot be installed: it conflicts with one that libvtk9-dev
# needs, and apt would remove that.
fetch_paraview_python() {
    if ! command -v dpkg-query >/dev/null; then
        return
    fi
    local directory=$1 version unpacked
    version=$(dpkg-query -W -f '${Version}' paraview)
    if [ "$(cat "$directory/version" 2>/dev/null)" = "$version" ]; then
        return
    fi
    unpacked=$(mktemp -d)
    echo "Fetching ParaView's Python modules ..."
    if ! (cd "$unpacked" &&
          apt-get -q -o APT::Sandbox::User="$(id -un)" download "python3-paraview=$version" &&
          dpkg -x ./*.deb .) >"$unpacked/log" 2>&1; then
        cat "$unpacked/log" >&2
        rm -rf "$unpacked"
        echo "error: python3-paraview $version could not be fetched: check the network and run apt-get update," >&2
        echo "    or leave the viewers out" >&2
        exit 4
    fi
    rm -rf "$directory"
    mkdir -p "$directory"
    mv "$unpacked/usr" "$directory/usr"
    echo "$version" >"$directory/version"
    rm -rf "$unpacked"
}
