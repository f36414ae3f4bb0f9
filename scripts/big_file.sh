#!/bin/sh
# Memory on files that do not fit: simulates a UVFITS file of about SIZE_GB gigabytes, converts it to UVH5 and a
# Measurement Set, looks at each with `vis2cat info`, finds the source in each, and prints the peak memory of
# every step.
#
#   sh scripts/big_file.sh SIZE_GB [FOLDER]     (FOLDER: where the files go; target/big if not given)
#
# Needs three times the disk, GNU time (Debian package `time`) and a release build. The files are removed at
# the end.
set -eu
cd "$(dirname "$0")/.."
size_gb=${1:?"usage: sh scripts/big_file.sh SIZE_GB [FOLDER]"}
folder=${2:-target/big}
[ $# -lt 2 ] && shift || shift 2
. scripts/debian.sh
[ -x /usr/bin/time ] || install_packages time
[ -x target/release/vis2cat ] || cargo build --release

mkdir -p "$folder"
trap 'rm -rf "$folder"/big.* "$folder/peak" "$folder/sky.csv"' EXIT

# 27 dishes for one hour of 10 s: 351 baselines, 360 times, 24 bytes a channel with two hands.
channels=$(awk -v gb="$size_gb" 'BEGIN { n = int(gb * 1e9 / (351 * 360 * 24) + 0.5); print n < 1 ? 1 : n }')

measure() {
    echo "== $*"
    /usr/bin/time -f '%M %e' -o "$folder/peak" "$@"
    awk '{ printf "peak memory %.1f MB, %.1f s\n", $1 / 1024, $2 }' "$folder/peak"
}

vis2cat=target/release/vis2cat
printf 'RA,DEC,Total_flux,Scale_length\n53.1005,30.0005,2000,1.5\n' > "$folder/sky.csv"
measure $vis2cat simulate "$folder/big.uvfits" --array vla-b --dec 30deg --hours 1 --tint 10s \
    --channels "$channels" --bandwidth 20MHz --catalogue "$folder/sky.csv" --overwrite
for format in uvfits uvh5 ms; do
    file="$folder/big.$format"
    [ $format = uvfits ] || measure $vis2cat convert "$folder/big.uvfits" "$file" --overwrite
    du -k --apparent-size -s "$file" | awk '{ printf "%s: %.2f GB\n", $2, $1 * 1024 / 1e9 }'
    measure $vis2cat info "$file"
    measure $vis2cat "$file" "$folder/big.fits" --fov 30arcsec --tiles 4 --n-live 50 \
        --flux 1mJy:4mJy --overwrite "$@"
done
