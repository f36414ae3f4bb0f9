#!/bin/sh
# Builds a target, gathers its seeds and runs it: formats/fuzz/fuzz.sh TARGET [SECONDS]
#
# TARGET is uvfits, uvh5 or ms. Needs a nightly Rust, cargo-fuzz and clang with its run-time libraries (Debian: clang
# and libclang-rt-14-dev), which builds the C libraries with AddressSanitizer and libFuzzer's counters, as rustc does
# ours; libFuzzer itself is clang's, built without. cargo's home is one of its own: CFITSIO is built beside its
# sources, where every other build would find what was made for this one. What crashes, hangs or takes too much
# memory is kept in artifacts/TARGET, and the run goes on.
set -eu
cd "$(dirname "$0")"
target=$1
end=$(($(date +%s) + ${2:-3600}))
here=$PWD
export CC="${CC:-clang}" CXX="${CXX:-clang++}"
export CFLAGS="-fsanitize=address,fuzzer-no-link" CXXFLAGS="-fsanitize=address,fuzzer-no-link"
CUSTOM_LIBFUZZER_PATH="$("$CC" -print-runtime-dir)/libclang_rt.fuzzer-x86_64.a"
export CUSTOM_LIBFUZZER_PATH CARGO_HOME="$here/target/home" CARGO_TARGET_DIR="$here/target"
# casacore does not free all that it has. Where there is no memory it gets a null, as it may without the sanitizer.
export ASAN_OPTIONS="detect_leaks=0:allocator_may_return_null=1:quarantine_size_mb=16"

features=
max_len=70000
seeds="corpus/$target-seeds"
mkdir -p "$seeds" "corpus/$target" "artifacts/$target"
# Files are made and thrown away: in memory, if there is such a place.
if [ -d /dev/shm ]; then
    TMPDIR=$(mktemp -d -p /dev/shm)
    export TMPDIR
fi
if [ "$target" = ms ]; then
    features="--features ms"
    max_len=2000000
    # Without the tables that are not read, so that more of what is changed matters. Smaller sets are read
    # faster: put tars of what the example rewrite_vis writes into corpus/ms.
    for set in ../../fixtures/good/*.ms.tar.gz ../../fixtures/bad/*.ms.tar.gz; do
        folder=$(mktemp -d)
        tar -xzf "$set" -C "$folder"
        for part in FEED FLAG_CMD POINTING PROCESSOR SOURCE STATE; do
            rm -rf "$folder"/*/$part
        done
        (cd "$folder" && tar --format=ustar -cf - ./*) > "$seeds/$(basename "$set" .gz)"
        rm -rf "$folder"
    done
else
    # Those of shared/data, where there are any, unless they are too long.
    for file in ../../fixtures/good/*."$target" ../../fixtures/bad/*."$target" ../../../shared/data/*."$target"; do
        if [ -f "$file" ] && [ "$(wc -c < "$file")" -le $max_len ]; then
            cp "$file" "$seeds/"
        fi
    done
fi
# shellcheck disable=SC2086 # no word or two
cargo +nightly fuzz build --fuzz-dir . $features "$target"
while left=$((end - $(date +%s))) && [ "$left" -gt 0 ]; do
    nice -n 19 "target/x86_64-unknown-linux-gnu/release/$target" -timeout=60 -rss_limit_mb=9000 \
        -malloc_limit_mb=2000 -max_len=$max_len -max_total_time="$left" -close_fd_mask=2 \
        -artifact_prefix="artifacts/$target/" "corpus/$target" "$seeds" || true
    # What a crash left behind.
    [ -n "${TMPDIR:-}" ] && rm -rf "$TMPDIR"/.tmp*
done
