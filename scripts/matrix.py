#!/usr/bin/env python3
"""Writer x reader matrix: one simulated observation, written by us and by pyuvdata in every format, read by
us, pyuvdata, python-casacore and WSClean.

    matrix.py --target target/release

A cell is what was compared and the largest difference: visibilities by the largest of them, (u, v, w) in
metres, flags and weights as counts of those that differ. WSClean images a set and its peaks are compared
with the sources that were simulated: the cell is the largest distance in arcsec. The exit code is 1 if a
cell is red. Needs pyuvdata with python-casacore, and wsclean.
"""

import argparse
import pathlib
import shutil
import subprocess
import sys
import tempfile
import warnings

import numpy as np

warnings.simplefilter("ignore")
import logging  # noqa: E402

logging.disable(logging.WARNING)
from pyuvdata import UVData  # noqa: E402

FORMATS = ("uvfits", "uvh5", "ms")
RA_DEG, DEC_DEG = 53.1, -30.0
# Without any symmetry: east and north of the phase centre [arcsec].
OFFSETS = ((60.0, 30.0), (-45.0, 72.0), (90.0, -66.0))
MOST_ARCSEC = 0.1


def vis2cat(target, *arguments):
    subprocess.run([str(target / "vis2cat"), *map(str, arguments)], check=True, capture_output=True)


def simulate(target, folder):
    sky = folder / "sky.csv"
    lines = ["RA[deg],DEC[deg],Total_flux[uJy],Scale_length[arcsec],E1,E2"]
    lines += [f"{ra:.9f},{dec:.9f},1e6,0.01,0,0" for ra, dec in places()]
    sky.write_text("\n".join(lines) + "\n")
    path = folder / "ours.uvfits"
    vis2cat(target, "simulate", path, "--array", "vla-b", "--ra", f"{RA_DEG}deg", "--dec", f"{DEC_DEG}deg",
            "--hours", 4, "--tint", "120s", "--channels", 4, "--freq", "1.4GHz", "--catalogue", sky, "--seed", 1,
            *FEW_CHANNELS)
    return path


# Narrow, so that no source is smeared.
FEW_CHANNELS = ("--bandwidth", "4MHz")


def places():
    """Right ascension and declination of the sources [deg], from offsets in the tangent plane."""
    ra0, dec0 = np.radians([RA_DEG, DEC_DEG])
    for east, north in OFFSETS:
        l, m = np.radians([east / 3600, north / 3600])
        n = np.sqrt(1 - l * l - m * m)
        dec = np.arcsin(m * np.cos(dec0) + n * np.sin(dec0))
        ra = ra0 + np.arctan2(l, n * np.cos(dec0) - m * np.sin(dec0))
        yield np.degrees(ra), np.degrees(dec)


def by_pyuvdata(path):
    """Axes (row, channel, correlation), rows by time and baseline, baselines from the smaller number."""
    data = UVData()
    data.read(str(path), run_check=True, strict_uvw_antpos_check=False)
    data.reorder_pols("CASA")
    data.reorder_blts(order="time", conj_convention="ant1<ant2")
    return {"vis": data.data_array, "flag": data.flag_array, "weight": data.nsample_array,
            "uvw": data.uvw_array}


def by_us(target, path, folder):
    """What we read, through UVH5 that pyuvdata reads: ours is the reader that is looked at."""
    out = folder / "as_we_read_it.uvh5"
    vis2cat(target, "convert", path, out, "--overwrite")
    return by_pyuvdata(out)


def by_casacore(path):
    from casacore.tables import table

    main = table(str(path), ack=False)
    vis, flag = main.getcol("DATA"), main.getcol("FLAG")
    weight = main.getcol("WEIGHT_SPECTRUM") if "WEIGHT_SPECTRUM" in main.colnames() else \
        np.repeat(main.getcol("WEIGHT")[:, None, :], vis.shape[1], axis=1)
    a, b, time, uvw = (main.getcol(name) for name in ("ANTENNA1", "ANTENNA2", "TIME", "UVW"))
    turned = a > b
    vis[turned], uvw = np.conj(vis[turned]), np.where(turned[:, None], uvw, -uvw)
    # pyuvdata has baselines the other way, and conjugates with them.
    vis = np.conj(vis)
    order = np.lexsort((np.maximum(a, b), np.minimum(a, b), np.round(time)))
    return {"vis": vis[order], "flag": flag[order], "weight": weight[order], "uvw": uvw[order]}


def compared(found, wanted):
    if found["vis"].shape != wanted["vis"].shape:
        return False, f"shape {found['vis'].shape}, not {wanted['vis'].shape}"
    good = ~wanted["flag"]
    vis = np.abs(found["vis"] - wanted["vis"])[good].max() / np.abs(wanted["vis"][good]).max()
    n_flag = int((found["flag"] != wanted["flag"]).sum())
    n_weight = int((np.abs(found["weight"] / wanted["weight"] - 1) > 1e-5)[good].sum())
    uvw_m = np.abs(found["uvw"] - wanted["uvw"]).max()
    is_good = vis < 1e-6 and n_flag == 0 and n_weight == 0 and uvw_m < 2e-3
    return is_good, f"vis {vis:.0e} flags {n_flag} weights {n_weight} uvw {uvw_m:.0e} m"


def by_wsclean(path, folder):
    """The largest distance of a source from the peak of the image near it [arcsec]."""
    from astropy.io import fits

    pixel = 0.5
    name = folder / f"image_{path.stem}"
    done = subprocess.run(["wsclean", "-name", str(name), "-size", "1024", "1024", "-scale", f"{pixel}asec",
                           "-niter", "2000", "-mgain", "0.8", "-auto-threshold", "5", "-weight", "briggs", "0",
                           "-no-update-model-required", "-quiet", str(path)], capture_output=True, text=True)
    if done.returncode:
        return False, done.stderr.strip().splitlines()[-1][:80]
    files = [p for p in folder.glob(f"image_{path.stem}*image.fits") if "dirty" not in p.name]
    header, image = fits.getheader(files[0]), fits.getdata(files[0])[0, 0]
    worst = 0.0
    for east, north in OFFSETS:
        x = header["CRPIX1"] - 1 - east / pixel
        y = header["CRPIX2"] - 1 + north / pixel
        i, j = int(round(x)), int(round(y))
        box = image[j - 6:j + 7, i - 6:i + 7]
        down, right = np.unravel_index(box.argmax(), box.shape)
        j, i = j - 6 + down, i - 6 + right
        # The top of the parabola through the peak and its neighbours.
        top = lambda a, b, c: 0.5 * (a - c) / (a - 2 * b + c)
        dx = i + top(image[j, i - 1], image[j, i], image[j, i + 1]) - x
        dy = j + top(image[j - 1, i], image[j, i], image[j + 1, i]) - y
        worst = max(worst, float(np.hypot(dx, dy)) * pixel)
    return worst < MOST_ARCSEC, f"sources within {worst:.3f} arcsec"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--target", type=pathlib.Path, default=pathlib.Path("target/release"))
    target = parser.parse_args().target
    cells = []
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        first = simulate(target, folder)
        data = UVData()
        data.read(str(first))
        written = {}
        for suffix in FORMATS:
            ours = folder / f"ours.{suffix}"
            if ours != first:
                vis2cat(target, "convert", first, ours)
            theirs = folder / f"pyuvdata.{suffix}"
            getattr(data, f"write_{suffix}")(str(theirs))
            written[f"vis2cat {suffix}"], written[f"pyuvdata {suffix}"] = ours, theirs
        wanted = by_pyuvdata(first)
        for writer, path in written.items():
            readers = {"vis2cat": lambda: compared(by_us(target, path, folder), wanted),
                       "pyuvdata": lambda: compared(by_pyuvdata(path), wanted)}
            if path.suffix == ".ms":
                readers["casacore"] = lambda: compared(by_casacore(path), wanted)
                if shutil.which("wsclean"):
                    readers["WSClean"] = lambda: by_wsclean(path, folder)
            for reader, look in readers.items():
                try:
                    is_good, words = look()
                except Exception as error:  # a reader's failure is a cell
                    is_good, words = False, f"{type(error).__name__}: {error}"[:100]
                cells.append(is_good)
                print(f"{writer:16} {reader:9} {'ok ' if is_good else 'RED'} {words}", flush=True)
    return int(not all(cells))


if __name__ == "__main__":
    sys.exit(main())
