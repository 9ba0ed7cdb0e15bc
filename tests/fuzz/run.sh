#!/usr/bin/env bash
# Runs each fuzz target for a bounded time, from the committed seeds; fails on any finding.
#   tests/fuzz/run.sh SECONDS_EACH BUILD_DIR [JOBS]
# JOBS targets run at a time (1).
# BUILD_DIR is a build folder in which the targets are built; they are looked for in it and below. What the run learns
# stays in BUILD_DIR/fuzz-corpus and makes the next one start further on; findings are kept in BUILD_DIR/fuzz-findings.
set -euo pipefail

if [[ $# -lt 2 || $# -gt 3 || ! $1 =~ ^[0-9]+$ || ! -d $2 || ! ${3:-1} =~ ^[1-9][0-9]*$ ]]; then
    echo "usage: $0 SECONDS_EACH BUILD_DIR [JOBS]" >&2
    exit 1
fi
seconds=$1
build=$(cd "$2" && pwd)
jobs=${3:-1}
here=$(cd "$(dirname "$0")" && pwd)
cd "$here" # scenes of the corpus name files that are there
readers=(off obj ply stl gltf scene ies eulumdat image points field_ply field_vtp transport)

# fuzz READER: one target; whether it found nothing.
fuzz() {
    local reader=$1 target learned findings log
    target=$(find "$build" -name 'fuzz-*' -prune -o -name "fuzz_$reader" -type f -perm -u+x -print -quit)
    if [[ -z $target ]]; then
        echo "fuzz_$reader is not built in $build: build it first (see tests/fuzz/CMakeLists.txt)" >&2
        return 1
    fi
    learned=$build/fuzz-corpus/$reader
    findings=$build/fuzz-findings/$reader
    mkdir -p "$learned" "$findings"
    local dictionary=()
    [[ ! -f $here/$reader.dict ]] || dictionary=(-dict="$here/$reader.dict")
    log=$findings/log
    # Memory that AddressSanitizer keeps after it was freed, 256 MiB by default, would count towards the limit.
    if ASAN_OPTIONS=${ASAN_OPTIONS:+$ASAN_OPTIONS:}quarantine_size_mb=64 "$target" -max_total_time="$seconds" -timeout=5 -rss_limit_mb=512 -max_len=4096 -print_final_stats=1 \
        "${dictionary[@]}" -artifact_prefix="$findings/" "$learned" "$here/corpus/$reader" 2>"$log"; then
        echo "fuzz_$reader: $(sed -n 's/^stat::number_of_executed_units: *//p' "$log") inputs in $seconds s, no finding"
    else
        echo "fuzz_$reader: a finding, kept in $findings" >&2
        tail -n 40 "$log" >&2
        return 1
    fi
}

status=0 running=0
for reader in "${readers[@]}"; do
    if [[ $running -ge $jobs ]]; then
        wait -n || status=1
        running=$((running - 1))
    fi
    fuzz "$reader" &
    running=$((running + 1))
done
while [[ $running -gt 0 ]]; do
    wait -n || status=1
    running=$((running - 1))
done
exit $status
