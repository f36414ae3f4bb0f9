#!/bin/sh
# Installs what the tests need, and runs them all.
#
# The independent programs that check our files (fitsverify, STILTS, astropy, pyuvdata) are installed
# too: by apt-get, and into target/oracles. Where that cannot be done, the tests that need them say
# SKIPPED; where it is done, none may be skipped.
#
#   sh scripts/test.sh [arguments of cargo test]
set -eu
cd "$(dirname "$0")/.."
. scripts/debian.sh

need_commands gcc:gcc g++:g++ make:make cc:gcc cmake:cmake
need_files /usr/include/stdlib.h:libc6-dev
need_rust

oracles() {
    need_commands fitsverify:fitsverify stilts:stilts python3:python3 || return 1
    python3 -c 'import ensurepip' 2>/dev/null || install_packages python3-venv || return 1
    venv=$PWD/target/oracles
    if ! "$venv/bin/python" -c 'import pyuvdata, astropy, casacore' 2>/dev/null; then
        mkdir -p target
        python3 -m venv --clear "$venv" &&
            "$venv/bin/python" -m pip install -q --disable-pip-version-check \
                pyuvdata==3.2.8 astropy==8.0.2 numpy==2.3.5 python-casacore==3.8.1 ||
            return 1
    fi
}

if oracles; then
    VIS2CAT_PYTHON=$PWD/target/oracles/bin/python
    VIS2CAT_ORACLES=required
    export VIS2CAT_PYTHON VIS2CAT_ORACLES
else
    echo "not all programs that check our files could be installed: some tests will be SKIPPED" >&2
fi

cargo test --release --workspace "$@"
