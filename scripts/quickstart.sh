#!/bin/sh
# Installs what a Debian machine with Rust still needs, builds vis2cat, finds the sources in a
# simulated observation of ten galaxies, and shows the catalogue.
#
#   sh scripts/quickstart.sh [OUT.fits]     (target/quickstart.fits if no name is given)
set -eu
cd "$(dirname "$0")/.."
. scripts/debian.sh

need_commands gcc:gcc g++:g++ make:make cc:gcc cmake:cmake
need_files /usr/include/stdlib.h:libc6-dev
need_rust

cargo build --release
out=${1:-target/quickstart.fits}
target/release/vis2cat info fixtures/ska30.uvfits
target/release/vis2cat fixtures/ska30.uvfits "$out" --fov 10arcmin --flux 20uJy:500uJy --overwrite
echo "Catalogue: $out, posterior samples: ${out%.*}.posterior.fits; what went in: fixtures/ska30_truth.csv"
