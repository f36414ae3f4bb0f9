#!/usr/bin/env python3
"""Checks `vis2cat evaluate` against astropy and numpy.

Usage: check_evaluate.py PROGRAM CATALOGUE.fits TRUTH.fits

The pairs are those that match_to_catalog_sky finds in both directions within three sigma or one
arcsecond; offsets, pulls, medians of the posterior and coverage are computed anew from the tables.
Only for fields in which no two sources compete for a match. Exit status 1 if a number differs.
"""

import json
import pathlib
import subprocess
import sys
import warnings

import numpy as np
from astropy import units as u
from astropy.coordinates import SkyCoord
from astropy.table import QTable

PARAMETERS = ("RA", "DEC", "Total_flux", "Scale_length", "E1", "E2")
SAMPLES = ("ra", "dec", "flux", "scale", "e1", "e2")


def directions(table, ra="RA", dec="DEC"):
    return SkyCoord(u.Quantity(table[ra]), u.Quantity(table[dec]))


def pairs(rows, truth):
    """Row and true source that are nearest to each other and near enough."""
    here, there = directions(rows), directions(truth)
    nearest, separation, _ = here.match_to_catalog_sky(there)
    back, _, _ = there.match_to_catalog_sky(here)
    radius = np.maximum(3 * np.hypot(rows["E_RA"], rows["E_DEC"]), 1 * u.arcsec)
    mutual = back[nearest] == np.arange(len(rows))
    return [(int(i), int(nearest[i]), separation[i]) for i in np.flatnonzero(mutual & (separation <= radius))]


def value(quantity, unit):
    return u.Quantity(quantity).to_value(unit)


def differences(rows, truth, i, j):
    """Estimate minus truth of every parameter, in the unit of its error."""
    east, north = directions(truth)[j].spherical_offsets_to(directions(rows)[i])
    others = [rows[name][i] - truth[name][j] for name in PARAMETERS[2:]]
    errors = [rows[f"E_{name}"][i] for name in PARAMETERS]
    units = [u.arcsec, u.arcsec, u.uJy, u.arcsec, u.one, u.one]
    return [(value(d, unit), value(e, unit))
            for d, e, unit in zip([east, north, *others], errors, units)]


def ranks(samples, rows, truth, i, j):
    """Fraction of the weight of the posterior below the truth, for every parameter."""
    own = samples[int(rows["Post_row"][i]):][:int(rows["Post_n"][i])]
    east, north = directions(truth)[j].spherical_offsets_to(directions(own, "ra", "dec"))
    above = [east, north] + [own[s] - truth[t][j] for s, t in zip(SAMPLES[2:], PARAMETERS[2:])]
    weight = np.array(own["weight"])
    return [float(weight[np.array(value(x, x.unit if hasattr(x, "unit") else u.one)) < 0].sum()
                  / weight.sum()) for x in above]


def complaints(found, rows, truth, samples):
    expected = pairs(rows, truth)
    got = [(m["row"] - 1, m["truth_row"] - 1) for m in found["matched"]]
    if got != [(i, j) for i, j, _ in expected]:
        yield f"pairs {got}, astropy {expected}"
        return
    for entry, (i, j, separation) in zip(found["matched"], expected):
        if abs(entry["separation_arcsec"] - separation.to_value(u.arcsec)) > 1e-6:
            yield f"row {i}: {entry['separation_arcsec']} arcsec, astropy {separation.to(u.arcsec)}"
    table = np.array([differences(rows, truth, i, j) for i, j, _ in expected])
    pulls = table[:, :, 0] / table[:, :, 1]
    below = np.array([ranks(samples, rows, truth, i, j) for i, j, _ in expected])
    for k, (name, entry) in enumerate(zip(PARAMETERS, found["parameters"])):
        low, high = (0.16, 0.84), (0.025, 0.975)
        inside = [int(np.sum((below[:, k] >= a) & (below[:, k] <= b))) for a, b in (low, high)]
        if name == "Total_flux":
            flux = [truth["Total_flux"][j] for _, j, _ in expected]
            inside[0] = sum(rows["Total_flux_lo"][i] <= f <= rows["Total_flux_hi"][i]
                            for f, (i, _, _) in zip(flux, expected))
        numbers = {
            "bias": (entry["bias"]["value"], table[:, k, 0].mean()),
            "pull_mean": (entry["pull_mean"], pulls[:, k].mean()),
            "pull_rms": (entry["pull_rms"], np.sqrt(np.mean(pulls[:, k]**2))),
            "68%": (entry["coverage"][0]["covered"]["n"], inside[0]),
            "95%": (entry["coverage"][1]["covered"]["n"], inside[1]),
        }
        for what, (ours, theirs) in numbers.items():
            if name != entry["name"] or not abs(ours - theirs) < 1e-5:
                yield f"{entry['name']} {what}: {ours}, by astropy and numpy {theirs}"


def main(program, catalogue, truth):
    done = subprocess.run([program, "evaluate", "--json", catalogue, truth],
                          capture_output=True, text=True, check=True)
    posterior = pathlib.Path(catalogue).with_suffix(".posterior.fits")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # Of empty columns and the like.
        tables = [QTable.read(path, hdu=1) for path in (catalogue, truth, posterior)]
    rows, true_sources, samples = tables
    found = json.loads(done.stdout)
    wrong = list(complaints(found, rows, true_sources, samples))
    print(f"{len(found['matched'])} pairs, {len(wrong)} differences", *wrong, sep="\n  ")
    return 1 if wrong or not found["matched"] else 0


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
