#!/usr/bin/env python3
"""Visibilities gridded per second and core: our facets beside the wgridder of ducc0.

Both spread the same observation (197 dishes of SKA1-MID, 8 h, 60 s samples: 9.3 million visibilities) to
the same accuracy, 1e-5, over the same patch of sky, on one core. Ours makes two complex grids at a time,
of the data and of the data times w; ducc0 makes one, without w-stacking and with the transform, which
is a hundredth of its time.

    python3 scripts/bench_gridding.py [--side ARCSEC] [--n-time N]      needs numpy, astropy, ducc0
"""

import argparse
import re
import subprocess
import tempfile
import time

import ducc0
import numpy as np
from astropy.io import fits

LIGHT_M_S = 299_792_458.0


def ours(n_time, side):
    """What the bench prints: samples, longest baseline [wavelength], cells to it, ns per visibility."""
    command = ["cargo", "bench", "--bench", "facet", "--", str(n_time), str(side)]
    text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    number = lambda pattern: float(re.search(pattern, text).group(1))
    ns = number(r"one core: ([\d.]+) ns per visibility for each")
    return int(number(r"(\d+) samples")), number(r"uv: ([\d.]+)"), int(number(r"levels of (\d+) x")), ns


def observation(n_time):
    """(u, v, w) of the same array, hours and frequency [m], as `vis2cat simulate` writes them."""
    with tempfile.TemporaryDirectory() as folder:
        path = f"{folder}/field.uvfits"
        simulate = ["cargo", "run", "--release", "--quiet", "--", "simulate", path, "--array", "ska1-mid"]
        tint = f"{8 * 3600 / n_time}s"
        subprocess.run([*simulate, "--sources", "1", "--sefd", "400Jy", "--tint", tint, "--quiet"], check=True)
        with fits.open(path) as hdus:
            rows = hdus[0].data
            return LIGHT_M_S * np.stack([rows.par(name) for name in ("UU", "VV", "WW")], axis=1).astype(float)


def theirs(uvw_m, period, pixels):
    """ns per visibility of ducc0."""
    rng = np.random.default_rng(1)
    vis = (rng.standard_normal((len(uvw_m), 2)) @ [1, 1j]).astype(np.complex64)[:, None]
    best = np.inf
    for _ in range(3):
        start = time.perf_counter()
        ducc0.wgridder.vis2dirty(
            uvw=uvw_m,
            freq=np.array([1.4e9]),
            vis=vis,
            npix_x=pixels,
            npix_y=pixels,
            pixsize_x=period / pixels,
            pixsize_y=period / pixels,
            epsilon=1e-5,
            do_wgridding=False,
            nthreads=1,
        )
        best = min(best, time.perf_counter() - start)
    return 1e9 * best / len(uvw_m)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--side", type=float, default=20, help="side of a facet [arcsec]")
    parser.add_argument("--n-time", type=int, default=480, help="time samples")
    args = parser.parse_args()
    count, reach, rows, ns = ours(args.n_time, args.side)
    # As many cells to the longest baseline as our finest level has.
    pixels = 2 * rows
    peer = theirs(observation(args.n_time), rows / reach, pixels)
    print(f"{count} visibilities, patch of {args.side} arcsec, grid of {pixels} cells across")
    print(f"vis2cat      {ns:6.1f} ns a visibility, {1e3 / ns:6.1f} million a second and core")
    print(f"ducc0 {ducc0.__version__} {peer:6.1f} ns a visibility, {1e3 / peer:6.1f} million a second and core")
    print(f"ratio {peer / ns:.2f}")


if __name__ == "__main__":
    main()
