#!/bin/sh
# in_scratch_directory.sh DIRECTORY COMMAND...: runs the command in the directory, made anew and empty.
set -eu
rm -rf "$1"
mkdir -p "$1"
cd "$1"
shift
exec "$@"
