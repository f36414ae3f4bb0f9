#!/usr/bin/env python3
"""Compare our UVH5 reader and writer with pyuvdata's, both ways.

    check_uvh5.py FILE ...

Each file is UVFITS or UVH5. What our reader decodes must equal what pyuvdata reads; the UVH5 file
that our writer makes of it must pass pyuvdata's strict checks without a warning and equal the
original, and so must what pyuvdata writes of it, read by us. Build the helpers first:
`cargo build --release -p vis2cat-formats --examples`. Needs pyuvdata >= 3.2.

pyuvdata holds r(ant2) - r(ant1) and conjugates UVFITS on reading; our chunks have the baselines as
UVFITS has them. So here its uvw are negated and its data conjugated.
"""

import argparse
import pathlib
import subprocess
import sys
import tempfile
import warnings

import h5py
import numpy as np

from check_uvfits import ROOT, Check, Ours, compare, read_pyuvdata

# A Julian date in 64 bits is as fine as this [s].
TIME_TOL_S = 5e-5


def check_strictly(check, path):
    """pyuvdata's checks, all of them, and no warning on the way."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        uv = read_pyuvdata(path, strict=0)
        try:
            uv.check(check_extra=True, run_check_acceptability=True, strict_uvw_antpos_check=True,
                     allow_flip_conj=False, check_freq_spacing=True, check_autos=True)
        except ValueError as error:
            check.ok("pyuvdata's check", False, str(error))
    check.ok("pyuvdata's warnings", not told, "; ".join(str(w.message) for w in told))
    return uv


def compare_places(check, uv):
    """The apparent places of the phase centres; ours are geocentric."""
    ours = [a.copy() for a in (uv.phase_center_app_ra, uv.phase_center_app_dec, uv.phase_center_frame_pa)]
    uv._set_app_coords_helper()
    theirs = (uv.phase_center_app_ra, uv.phase_center_app_dec, uv.phase_center_frame_pa)
    for name, a, b in zip(("RA", "Dec", "frame PA"), ours, theirs):
        check.close(f"apparent {name} [arcsec]", np.degrees(a) * 3600, np.degrees(b) * 3600, 1.5)


def compare_storage(check, path):
    """Chunks and filters: what is small when packed is packed."""
    with h5py.File(path) as f:
        for name in ("flags", "nsamples"):
            data = f["Data"][name]
            check.ok(f"{name} are packed", data.compression == "gzip" and data.shuffle)
        for data in f["Data"].values():
            whole = np.prod(data.chunks) * data.dtype.itemsize
            check.ok("chunks are of a megabyte at most", whole <= 2**20, f"{data.name} {whole}")


def compare_pyuvdata(check, a, b):
    """pyuvdata's view of the original against its view of what we wrote from it."""
    check.ok("counts", all(getattr(a, n) == getattr(b, n) for n in
                           ("Nblts", "Nfreqs", "Npols", "Nspws", "Ntimes", "Nants_data")))
    # Old files count every row as a baseline.
    check.ok("Nbls", len(np.unique(a.baseline_array)) == b.Nbls)
    check.close("uvw [m]", a.uvw_array, b.uvw_array, 1e-9)
    check.close("time [s]", (a.time_array - b.time_array) * 86400, 0 * a.time_array, TIME_TOL_S)
    check.ok("frequencies", np.allclose(a.freq_array, b.freq_array, rtol=0, atol=1e-3))
    check.ok("channel widths", np.allclose(np.abs(a.channel_width), np.abs(b.channel_width)))
    check.ok("polarizations", np.array_equal(a.polarization_array, b.polarization_array))
    odd = ~np.isfinite(a.data_array)
    flags = a.flag_array.astype(bool) | odd
    usable = a.nsample_array > 0
    check.ok("flags", np.array_equal((flags | ~usable), b.flag_array))
    check.ok("nsamples", np.array_equal(a.nsample_array[~b.flag_array], b.nsample_array[~b.flag_array]))
    check.ok("data", np.array_equal(a.data_array.astype("c8")[~odd], b.data_array[~odd]))
    names = lambda uv: sorted(e["cat_name"] for e in uv.phase_center_catalog.values()
                              if e["cat_type"] == "sidereal")
    check.ok("phase centres", names(a) == names(b))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="+", type=pathlib.Path)
    parser.add_argument("--target", type=pathlib.Path, default=ROOT / "target" / "release")
    arguments = parser.parse_args()
    tools = arguments.target / "examples"
    bad = 0
    for path in arguments.files:
        check = Check(path.name)
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            uv = read_pyuvdata(path, strict=0)
            if not np.any(uv.nsample_array[~uv.flag_array.astype(bool)] > 0):
                # We take such nsamples as absent.
                uv.nsample_array[:] = 1
            compare(check, Ours(tools, path, folder), uv, 1e-9, 1e-4)

            check.name = f"{path.name} written by us"
            written = folder / "ours.uvh5"
            subprocess.run([tools / "rewrite_vis", path, written], check=True)
            back = check_strictly(check, written)
            compare(check, Ours(tools, written, folder), back, 0, TIME_TOL_S)
            compare_pyuvdata(check, uv, back)
            compare_storage(check, written)
            compare_places(check, back.copy())

            check.name = f"{path.name} written by pyuvdata"
            theirs = folder / "theirs.uvh5"
            uv.write_uvh5(theirs, run_check=False)
            compare(check, Ours(tools, theirs, folder), uv, 1e-9, 1e-4)
        print(f"{'ok ' if check.bad == 0 else 'BAD'} {path.name}: {uv.Nblts} rows")
        bad += check.bad
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
