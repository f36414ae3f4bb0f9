#!/usr/bin/env python3
"""Compare the (u, v, w) of `vis2cat simulate` with pyuvdata's.

    pip install pyuvdata astropy astropy-iers-data
    scripts/check_simulate_uvw.py                 # the geometry alone: arrays, declinations, dates
    scripts/check_simulate_uvw.py FILE.uvfits ... # whole files as pyuvdata reads them

The first form runs the ignored test `write_uvw_for_pyuvdata`, which writes our (u, v, w) of every dish of some
arrays; a UVData object with the same antennas, times and phase centre is made, phased, and compared over
all pairs of dishes. The second form reads each file (the ignored test `write_uvfits_for_pyuvdata` leaves some
in target/tmp), keeps its (u, v, w), has pyuvdata work them out anew from the
antenna table, and compares. pyuvdata holds ant2 - ant1 and a UVFITS file ant1 - ant2; it changes the sign as it
reads. Fails above 1 mm.

A file adds what its format costs: pyuvdata holds a Julian date in one f64 (to 20 us, 0.25 mm on 160 km), and a
single-precision (u, v, w) is good to 5 mm on 160 km unless it is split in two.
"""

import csv
import itertools
import pathlib
import subprocess
import sys

import numpy as np
from astropy.coordinates import EarthLocation
from astropy.utils import iers
from pyuvdata import Telescope, UVData

ROOT = pathlib.Path(__file__).resolve().parent.parent
LIMIT_MM = 1.0


def our_cases():
    command = ["cargo", "test", "--release", "--test", "it", "--", "--ignored", "write_uvw_for_pyuvdata"]
    subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    with open(ROOT / "target" / "tmp" / "simulate_uvw.csv", newline="") as file:
        rows = csv.DictReader(file)
        key = lambda row: (row["array"], float(row["ra_deg"]), float(row["dec_deg"]), float(row["mjd"]))
        for case, rows in itertools.groupby(rows, key):
            rows = list(rows)
            numbers = lambda *names: np.array([[float(row[name]) for name in names] for row in rows])
            yield case, numbers("x_m", "y_m", "z_m"), numbers("u_m", "v_m", "w_m")


def pyuvdata_uvw_m(itrf_m, ra_deg, dec_deg, mjd):
    """pyuvdata's (u, v, w) of each dish less the first one's."""
    centre_m = itrf_m.mean(axis=0)
    telescope = Telescope.new(
        name="test",
        location=EarthLocation.from_geocentric(*centre_m, unit="m"),
        antenna_positions=dict(enumerate(itrf_m - centre_m)),
        instrument="test",
        mount_type="alt-az",
    )
    uvd = UVData.new(
        freq_array=np.array([1.4e9]),
        polarization_array=["XX"],
        times=np.array([2400000.5 + mjd]),
        telescope=telescope,
        antpairs=[(0, k) for k in range(1, len(itrf_m))],
        integration_time=1.0,
        channel_width=1e6,
        x_orientation="east",
        empty=True,
    )
    uvd.phase(lon=np.radians(ra_deg), lat=np.radians(dec_deg), phase_frame="icrs", cat_name="centre")
    assert np.all(uvd.ant_1_array == 0)
    uvw_m = np.zeros_like(itrf_m)
    uvw_m[uvd.ant_2_array] = uvd.uvw_array
    return uvw_m


def largest_mm(ours_m, theirs_m):
    """Largest length of a difference over all pairs."""
    difference_m = ours_m - theirs_m
    pairs_m = difference_m[:, None, :] - difference_m[None, :, :]
    return 1e3 * np.sqrt((pairs_m**2).sum(axis=2)).max()


def check_geometry():
    worst_mm = 0.0
    for (array, ra_deg, dec_deg, mjd), itrf_m, ours_m in our_cases():
        theirs_m = pyuvdata_uvw_m(itrf_m, ra_deg, dec_deg, mjd)
        difference_mm = largest_mm(ours_m, theirs_m)
        worst_mm = max(worst_mm, difference_mm)
        print(f"{array:10} ra {ra_deg:6.1f} dec {dec_deg:6.1f} mjd {mjd:.6f}: {difference_mm:.6f} mm")
    return worst_mm


def check_file(path):
    uvd = UVData.from_file(path, fix_old_proj=False, run_check=False)
    stored_m = uvd.uvw_array.copy()
    # what the file's header gives of apparent places is dropped: all is worked out from ICRS
    uvd.set_lsts_from_time_array()
    uvd._set_app_coords_helper()
    uvd.set_uvws_from_antenna_positions(update_vis=False)
    difference_mm = 1e3 * np.linalg.norm(uvd.uvw_array - stored_m, axis=1).max()
    longest_m = np.linalg.norm(stored_m, axis=1).max()
    print(f"{path}: {uvd.Nblts} rows, longest baseline {longest_m:.1f} m: {difference_mm:.6f} mm")
    return difference_mm


def main():
    iers.conf.auto_download = False
    paths = sys.argv[1:]
    worst_mm = max(map(check_file, paths)) if paths else check_geometry()
    print(f"largest difference: {worst_mm:.6f} mm")
    return 0 if worst_mm < LIMIT_MM else 1


if __name__ == "__main__":
    sys.exit(main())
