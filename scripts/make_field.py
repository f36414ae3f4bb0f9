#!/usr/bin/env python3
"""Writes a UVFITS file with known galaxies, through pyuvdata and nothing of ours.

The model, the geometry, the noise and the file are made by numpy, astropy and pyuvdata, so that
what vis2cat reads and finds in it is checked against code that is not its own. Weights are 1, as
pyuvdata writes them; a tenth of the samples is flagged, with garbage under the flags.

    make_field.py OUT.uvfits TRUTH.csv --array ANTENNAS.csv [--seed 1] [--tint 60] ...

Needs pyuvdata (3.2 or later), astropy and numpy.
"""

import argparse
import csv
import logging

import numpy as np
from astropy.coordinates import EarthLocation
from astropy.time import Time
from pyuvdata import Telescope, UVData

ARCSEC = np.pi / 180 / 3600
C_M_S = 299792458.0
SEFD_JY, EFFICIENCY = 400.0, 0.9


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("uvfits")
    parser.add_argument("truth")
    parser.add_argument("--array", required=True, help="CSV with name,x_m,y_m,z_m,diameter_m")
    parser.add_argument("--max-antennas", type=int, help="take every n-th dish, by radius")
    parser.add_argument("--max-radius", type=float, default=np.inf, help="of the dishes taken [m]")
    parser.add_argument("--sources", type=int, default=10)
    parser.add_argument("--flux", nargs=2, type=float, default=[40.0, 300.0], help="[uJy]")
    parser.add_argument("--fov", type=float, default=10.0, help="side of the square [arcmin]")
    parser.add_argument("--min-snr", type=float, default=9.0)
    parser.add_argument("--min-separation", type=float, default=0.0, help="[arcsec]")
    parser.add_argument("--ra", type=float, default=53.1, help="[deg]")
    parser.add_argument("--dec", type=float, default=-30.0, help="[deg]")
    parser.add_argument("--hours", type=float, default=8.0)
    parser.add_argument("--tint", type=float, default=60.0, help="[s]")
    parser.add_argument("--flagged", type=float, default=0.1)
    parser.add_argument("--seed", type=int, default=1)
    return parser.parse_args()


def antennas(args):
    with open(args.array, newline="") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    xyz = np.array([[float(r[k]) for k in ("x_m", "y_m", "z_m")] for r in rows])
    radius = np.linalg.norm(xyz - np.median(xyz, axis=0), axis=1)
    order = np.argsort(radius, kind="stable")
    order = order[radius[order] <= args.max_radius]
    if args.max_antennas and len(order) > args.max_antennas:
        order = order[np.linspace(0, len(order) - 1, args.max_antennas).round().astype(int)]
    return xyz[order], [rows[i]["name"] for i in order], [float(rows[i]["diameter_m"]) for i in order]


def observation(args):
    xyz, names, diameters = antennas(args)
    centre = EarthLocation.from_geocentric(*xyz.mean(axis=0), unit="m")
    origin = np.array([centre.x.value, centre.y.value, centre.z.value])
    telescope = Telescope.new(
        name="SKA1-MID",
        location=centre,
        instrument="SIM",
        antenna_positions={i + 1: p for i, p in enumerate(xyz - origin)},
        antenna_names=names,
        antenna_diameters=np.array(diameters),
    )
    n_time = round(args.hours * 3600 / args.tint)
    transit = transit_jd(args.ra, centre)
    times = transit + (np.arange(n_time) + 0.5 - n_time / 2) * args.tint / 86400
    pairs = [(i, j) for i in range(1, len(names) + 1) for j in range(i + 1, len(names) + 1)]
    # New objects have their uvw computed by pyuvdata, which says so on its log.
    logging.disable(logging.WARNING)
    uvd = UVData.new(
        freq_array=np.array([1.4e9]),
        channel_width=240e6,
        polarization_array=np.array([-5, -6]),
        antpairs=np.array(pairs),
        times=times,
        telescope=telescope,
        integration_time=args.tint,
        do_blt_outer=True,
        time_axis_faster_than_bls=False,
        phase_center_catalog={
            0: {
                "cat_name": "FIELD",
                "cat_type": "sidereal",
                "cat_lon": np.deg2rad(args.ra),
                "cat_lat": np.deg2rad(args.dec),
                "cat_frame": "icrs",
                "cat_epoch": 2000.0,
            }
        },
        empty=True,
    )
    return uvd


def transit_jd(ra_deg, location):
    """Middle of the night's transit on 2020-01-01, to a second."""
    start = Time(2458849.5, format="jd", scale="utc", location=location)
    lst = start.sidereal_time("apparent").deg
    wait = ((ra_deg - lst) % 360) / 360 / 1.00273790935
    return round((start.jd + wait) * 86400) / 86400


def ellipticity(rng, n):
    """|e| by rejection from the VLA-COSMOS distribution, any orientation."""
    e_max, e_0, a = 0.804, 0.0732, 0.2298
    out = []
    while len(out) < n:
        e = rng.uniform(0, e_max)
        p = e * (1 - np.exp((e - e_max) / a)) / ((1 + e) * np.hypot(e, e_0))
        if rng.uniform(0, 1.0) < p:
            out.append(e)
    e, angle = np.array(out), rng.uniform(0, 2 * np.pi, n)
    return e * np.cos(angle), e * np.sin(angle)


def shape(uvw, alpha, e1, e2):
    """F of an exponential disk (Malyali et al. 2018)."""
    u, v = uvw[:, 0], uvw[:, 1]
    det = 1 - e1**2 - e2**2
    k1 = ((1 + e1) * u + e2 * v) / det
    k2 = (e2 * u + (1 - e1) * v) / det
    return (1 + (2 * np.pi * alpha) ** 2 * (k1**2 + k2**2)) ** -1.5


def population(args, rng, uvw, weight):
    """Galaxies from the priors, those below the wanted SNR drawn again."""
    sources = []
    low, high = args.flux
    index = -1.34 + 1
    while len(sources) < args.sources:
        flux = (low**index + rng.uniform() * (high**index - low**index)) ** (1 / index)
        log_alpha = -0.93 + 0.33 * np.log(flux) + 0.3136 * rng.normal()
        (e1,), (e2,) = ellipticity(rng, 1)
        half = args.fov / 2 * 60 * ARCSEC
        l, m = rng.uniform(-half, half, 2)
        alpha = np.clip(np.exp(log_alpha), 0.1, 10) * ARCSEC
        snr = flux * 1e-6 * np.sqrt((weight * shape(uvw, alpha, e1, e2) ** 2).sum())
        near = any(np.hypot(l - s[0], m - s[1]) < args.min_separation * ARCSEC for s in sources)
        if snr >= args.min_snr and not near:
            sources.append((l, m, flux * 1e-6, alpha, e1, e2, snr))
    return sources


def model(uvw, sources):
    vis = np.zeros(len(uvw), complex)
    for l, m, flux, alpha, e1, e2, _ in sources:
        n_1 = np.sqrt(1 - l * l - m * m) - 1
        phase = uvw @ np.array([l, m, n_1])
        vis += flux * shape(uvw, alpha, e1, e2) * np.exp(2j * np.pi * (phase - np.rint(phase)))
    return vis


def write_truth(args, sources):
    ra0, dec0 = np.deg2rad([args.ra, args.dec])
    with open(args.truth, "w", newline="") as file:
        out = csv.writer(file)
        out.writerow(
            ["RA[deg]", "DEC[deg]", "Total_flux[uJy]", "Scale_length[arcsec]", "E1", "E2", "SNR"]
        )
        for l, m, flux, alpha, e1, e2, snr in sources:
            n = np.sqrt(1 - l * l - m * m)
            dec = np.arcsin(m * np.cos(dec0) + n * np.sin(dec0))
            ra = ra0 + np.arctan2(l, n * np.cos(dec0) - m * np.sin(dec0))
            row = [np.rad2deg(ra), np.rad2deg(dec), flux * 1e6, alpha / ARCSEC, e1, e2, snr]
            out.writerow([f"{value:.10g}" for value in row])


def main():
    args = arguments()
    rng = np.random.default_rng(args.seed)
    uvd = observation(args)
    uvw = uvd.uvw_array * uvd.freq_array[0] / C_M_S
    sigma = SEFD_JY / (EFFICIENCY * np.sqrt(2 * 240e6 * args.tint))
    flags = rng.uniform(size=len(uvw)) < args.flagged
    weight = np.where(flags, 0.0, 2 / sigma**2)
    sources = population(args, rng, uvw, weight)
    vis = model(uvw, sources)
    for hand in range(2):
        noise = rng.normal(0, sigma, (2, len(uvw)))
        uvd.data_array[:, 0, hand] = vis + noise[0] + 1j * noise[1]
    uvd.data_array[flags] = 1e3 * (rng.normal(size=(flags.sum(), 1, 2)) + 7j)
    uvd.flag_array[:] = flags[:, None, None]
    uvd.nsample_array[:] = 1.0
    uvd.vis_units = "Jy"
    uvd.history = f"simulated by make_field.py with seed {args.seed}"
    uvd.check()
    uvd.write_uvfits(args.uvfits, force_phase=False)
    write_truth(args, sources)
    snr = [s[-1] for s in sources]
    print(f"{args.uvfits}: {len(uvw)} rows, SNR {min(snr):.1f} to {max(snr):.1f}")


if __name__ == "__main__":
    main()
