#!/bin/sh
# Builds a target, gathers its seeds and runs it: formats/fuzz/fuzz.sh TARGET [SECONDS]
#
# TARGET is uvfits, uvh5 or ms. Needs a nightly Rust, cargo-fuzz and clang, which builds the C libraries with
# AddressSanitizer and libFuzzer's counters, as rustc does ours. cargo's home is one of its own: CFITSIO
# is built beside its sources, where every other build would find what was made for this one. Crashes,
# hangs and what takes too much memory are kept in artifacts/TARGET and do not end the run.
set -eu
cd "$(dirname "$0")"
target=$1
seconds=${2:-3600}
here=$PWD
# Where files are made and thrown away: best in memory.
export TMPDIR="${FUZZ_TMPDIR:-/dev/shm}"
export CC="${CC:-clang}" CXX="${CXX:-clang++}"
export CFLAGS="-fsanitize=address,fuzzer-no-link" CXXFLAGS="-fsanitize=address,fuzzer-no-link"
export CARGO_HOME="$here/target/home" CARGO_TARGET_DIR="$here/target"
# Allocations beyond reason come back as null, as they may for us. casacore does not free all it has.
export ASAN_OPTIONS="detect_leaks=0:allocator_may_return_null=1:max_allocation_size_mb=2000"

features=
max_len=70000
seeds="corpus/$target-seeds"
mkdir -p "$seeds" "corpus/$target" "artifacts/$target"
if [ "$target" = ms ]; then
    features="--features ms"
    max_len=2000000
    # Without the subtables that are not read and the locks, so that more of what is changed matters.
    for set in ../../fixtures/good/*.ms.tar.gz; do
        folder=$(mktemp -d)
        tar -xzf "$set" -C "$folder"
        for part in FEED FLAG_CMD POINTING PROCESSOR SOURCE STATE; do
            rm -rf "$folder"/*/$part
        done
        (cd "$folder" && tar --format=ustar -cf - ./*) > "$seeds/$(basename "$set" .gz)"
        rm -rf "$folder"
    done
else
    # Those of shared/data, where there are any, are read as far as max_len.
    for file in ../../fixtures/good/*."$target" ../../fixtures/bad/*."$target" ../../../shared/data/*."$target"; do
        [ -f "$file" ] && [ "$(wc -c < "$file")" -le $max_len ] && cp "$file" "$seeds/"
    done
fi
cargo +nightly fuzz build --fuzz-dir . $features "$target"
# One process at a time, begun anew after each crash.
exec "target/x86_64-unknown-linux-gnu/release/$target" -fork=1 -ignore_crashes=1 -ignore_timeouts=1 \
    -ignore_ooms=1 -timeout=20 -rss_limit_mb=4096 -malloc_limit_mb=2048 -max_len=$max_len -close_fd_mask=2 \
    -max_total_time="$seconds" -artifact_prefix="artifacts/$target/" "corpus/$target" "$seeds"
