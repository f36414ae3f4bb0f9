#!/usr/bin/env python3
"""Make fixtures/good/*.uvfits: tiny files written by pyuvdata (3.2 or later), always the same.

    make_good_uvfits.py [FOLDER]

Each file has a JSON beside it with what a reader must find in it: sums and the first row, taken
from pyuvdata's arrays and turned to the file's own signs.
"""

import json
import pathlib
import sys
import warnings

import numpy as np
from astropy.coordinates import EarthLocation
from astropy.time import Time
from astropy.utils import iers
from pyuvdata import Telescope, UVData

iers.conf.auto_download = False
iers.conf.auto_max_age = None
warnings.simplefilter("ignore")

ROOT = pathlib.Path(__file__).resolve().parent.parent


def observe(numbers, n_time, n_spw, n_chan, pols, n_source, seed):
    """A UVData of random numbers with honest coordinates."""
    rng = np.random.default_rng(seed)
    n = len(numbers)
    site = EarthLocation.from_geodetic(21.44, -30.71, 1050.0)
    telescope = Telescope.new(
        name="TEST", instrument="TEST", location=site, x_orientation="east",
        antenna_names=[f"M{i:03d}" for i in numbers], antenna_numbers=numbers,
        antenna_positions=rng.normal(0, 500, (n, 3)), antenna_diameters=[13.5] * n,
    )
    mjd = 60000.75 + np.arange(n_time) * 8 / 86400
    pairs = [(a, b) for i, a in enumerate(numbers) for b in numbers[i:]]
    freq = np.concatenate([1.4e9 + 1e8 * s + 2.5e5 * np.arange(n_chan) for s in range(n_spw)])
    catalog = {i: {"cat_name": f"SRC{i}", "cat_type": "sidereal", "cat_lon": 0.3 + 0.01 * i,
                   "cat_lat": -0.6, "cat_frame": "icrs", "cat_epoch": 2000.0}
               for i in range(n_source)}
    n_blt = n_time * len(pairs)
    uv = UVData.new(
        freq_array=freq, polarization_array=pols, telescope=telescope,
        times=Time(mjd, format="mjd").jd, antpairs=pairs, do_blt_outer=True, integration_time=8.0,
        channel_width=2.5e5, phase_center_catalog=catalog,
        phase_center_id_array=np.repeat(np.arange(n_time) % n_source, len(pairs)),
        flex_spw_id_array=np.repeat(np.arange(1, n_spw + 1), n_chan),
        empty=True, vis_units="Jy", time_axis_faster_than_bls=False,
    )
    assert uv.Nblts == n_blt
    shape = uv.data_array.shape
    uv.data_array = (rng.normal(size=shape) + 1j * rng.normal(size=shape)).astype("c8")
    autos = uv.ant_1_array == uv.ant_2_array
    uv.data_array[autos] = np.abs(uv.data_array[autos])
    uv.nsample_array = rng.uniform(1, 4, shape).astype("f4")
    uv.flag_array = rng.uniform(size=shape) < 0.1
    uv.set_uvws_from_antenna_positions(update_vis=False)
    uv.history = "made by make_good_uvfits.py"
    return uv


def expectation(path):
    """What a reader must find, as pyuvdata sees it, with the baselines as a UVFITS file has them."""
    uv = UVData()
    if path.suffix == ".uvh5":
        # Old files have counts that pyuvdata does not take.
        uv.read_uvh5(path, run_check=False, fix_old_proj=False)
    else:
        uv.read_uvfits(path)
    good = ~uv.flag_array.astype(bool) & (uv.nsample_array > 0)
    data = np.conj(uv.data_array).astype("c8")
    total = np.sum(data[good].astype("c16"))
    return {
        "n_row": int(uv.Nblts),
        "n_chan": int(uv.Nfreqs),
        "n_corr": int(uv.Npols),
        "n_antenna": int(uv.telescope.Nants),
        "n_flagged": int((~good).sum()),
        "sum_vis": [total.real, total.imag],
        "sum_weight": float(np.sum(uv.nsample_array[good].astype("f8"))),
        "sum_uvw_m": [float(-x) for x in uv.uvw_array.sum(axis=0)],
        "first_uvw_m": [float(-x) for x in uv.uvw_array[1]],
        "first_vis": [float(data[1, 0, 0].real), float(data[1, 0, 0].imag)],
        "first_ant": [int(uv.ant_1_array[1]), int(uv.ant_2_array[1])],
        "first_mjd": float(Time(uv.time_array[0], format="jd").mjd),
        "freq_hz": [float(f) for f in uv.freq_array],
        "fields": [[e["cat_name"], e["cat_lon"], e["cat_lat"]]
                   for e in uv.phase_center_catalog.values()],
    }


def main():
    folder = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "fixtures" / "good"
    folder.mkdir(parents=True, exist_ok=True)
    made = {
        "pyuvdata_small": observe([1, 2, 3, 4], 3, 1, 2, [-5, -6], 1, 1),
        "pyuvdata_ifs_sources": observe([2, 5, 9], 4, 3, 2, [-1, -2, -3, -4], 2, 2),
        "pyuvdata_large_numbers": observe([1, 255, 256, 600, 2049], 2, 1, 1, [-5, -6, -7, -8], 1, 3),
        "pyuvdata_stokes_i": observe([1, 2, 3], 4, 1, 3, [1], 1, 4),
    }
    for name, uv in made.items():
        path = folder / f"{name}.uvfits"
        uv.write_uvfits(path)
        (folder / f"{name}.json").write_text(json.dumps(expectation(path), indent=1) + "\n")
        print(path, path.stat().st_size)


if __name__ == "__main__":
    main()
