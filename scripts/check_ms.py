#!/usr/bin/env python3
"""Compare our Measurement Set reader and writer with pyuvdata's, both ways.

    check_ms.py FILE ...

Each file is UVFITS or UVH5, of one spectral window and phased. The set that our writer makes of it
must be read by pyuvdata (over python-casacore) without an error and equal the original; it must have
the tables, columns and units that casacore gives to a new set; and what pyuvdata writes of the
original must be read by us as pyuvdata has it. Build the helpers first:
`cargo build --release -p vis2cat-formats --examples`. Needs pyuvdata >= 3.2 and python-casacore.

pyuvdata holds r(ant2) - r(ant1) and conjugates on reading; our chunks have the baselines as UVFITS
has them. So here its uvw are negated and its data conjugated.
"""

import argparse
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from casacore import tables
from pyuvdata import UVData

from check_uvfits import ROOT, Check, Ours, compare, read_pyuvdata

TIME_TOL_S = 5e-5


def read_set(path):
    uv = UVData()
    uv.read_ms(str(path), ignore_single_chan=False, run_check=False)
    # Not by read_ms, which would turn the baselines round where that helps.
    uv.check(check_extra=True, run_check_acceptability=True, strict_uvw_antpos_check=True,
             allow_flip_conj=False, check_freq_spacing=True)
    return uv


def compare_pyuvdata(check, a, b):
    """pyuvdata's view of the original against its view of the set that we made of it."""
    order = [list(b.polarization_array).index(p) for p in a.polarization_array]
    check.ok("counts", (a.Nblts, a.Nfreqs, a.Npols) == (b.Nblts, b.Nfreqs, b.Npols))
    check.close("uvw [m]", a.uvw_array, b.uvw_array, 1e-9)
    check.close("time [s]", (a.time_array - b.time_array) * 86400, 0 * a.time_array, TIME_TOL_S)
    check.close("interval [s]", a.integration_time, b.integration_time, 0)
    check.ok("frequencies", np.array_equal(a.freq_array, b.freq_array))
    names = [dict(zip(uv.telescope.antenna_numbers, map(str.strip, uv.telescope.antenna_names)))
             for uv in (a, b)]
    for ends in ("ant_1_array", "ant_2_array"):
        check.ok(ends, [names[0][i] for i in getattr(a, ends)] == [names[1][i] for i in getattr(b, ends)])
    bad = a.flag_array.astype(bool) | ~(a.nsample_array > 0)
    check.ok("flags", np.array_equal(bad, b.flag_array[..., order]))
    check.ok("data", np.array_equal(a.data_array.astype("c8"), b.data_array[..., order]))
    check.ok("weights", np.array_equal(a.nsample_array[~bad], b.nsample_array[..., order][~bad]))


def compare_with_default(check, path):
    """Every table and column of casacore's new set, of the same type and units."""
    with tempfile.TemporaryDirectory() as folder:
        wanted = pathlib.Path(folder) / "default.ms"
        tables.default_ms(str(wanted)).close()
        parts = [""] + sorted(p.parent.name for p in wanted.glob("*/table.dat"))
        for part in parts:
            with tables.table(str(wanted / part), ack=False) as a, \
                    tables.table(str(path / part), ack=False) as b:
                for name in a.colnames():
                    where = f"{part or 'MAIN'}.{name}"
                    check.ok(where, name in b.colnames(), "is missing")
                    if name not in b.colnames():
                        continue
                    kinds = [t.getcoldesc(name)["valueType"] for t in (a, b)]
                    check.ok(where, kinds[0] == kinds[1], str(kinds))
                    units = [t.getcolkeywords(name).get("QuantumUnits") for t in (a, b)]
                    check.ok(where, units[0] is None or units[0] == units[1], str(units))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="+", type=pathlib.Path)
    parser.add_argument("--target", type=pathlib.Path, default=ROOT / "target" / "release")
    arguments = parser.parse_args()
    tools = arguments.target / "examples"
    bad = 0
    for path in arguments.files:
        check = Check(f"{path.name} written by us")
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            uv = read_pyuvdata(path, strict=0)
            written = folder / "ours.ms"
            subprocess.run([tools / "rewrite_vis", path, written], check=True)
            compare_pyuvdata(check, uv, read_set(written))
            compare_with_default(check, written)

            check.name = f"{path.name} written by pyuvdata"
            theirs = folder / "theirs.ms"
            uv.write_ms(str(theirs), run_check=False)
            compare(check, Ours(tools, theirs, folder), read_set(theirs), 1e-9, TIME_TOL_S)
        print(f"{'ok ' if check.bad == 0 else 'BAD'} {path.name}: {uv.Nblts} rows")
        bad += check.bad
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
