#!/usr/bin/env python3
"""Draws a catalogue with its posterior samples: the picture in the README.

    plot_field.py OUT.fits PICTURE.png [TRUTH.csv]

Needs astropy, numpy and matplotlib.
"""

import csv
import sys

import matplotlib
import numpy as np
from astropy.table import Table

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.patches import Ellipse  # noqa: E402

BLUE, ORANGE, GREY = "#1f4e79", "#c65d00", "#888888"


def offsets(ra, dec, centre):
    """East and north of the centre [arcmin]."""
    return (ra - centre[0]) * np.cos(np.deg2rad(centre[1])) * 60, (dec - centre[1]) * 60


def field(axes, table, truth, centre):
    x, y = offsets(np.array(table["RA"]), np.array(table["DEC"]), centre)
    if truth is not None:
        tx, ty = offsets(truth[0], truth[1], centre)
        axes.plot(tx, ty, "+", color=ORANGE, ms=13, mew=1.2, label="truth")
    axes.scatter(x, y, s=np.array(table["SNR"]) * 4, fc="none", ec=BLUE, label="found (area: SNR)")
    for i, name in enumerate(table["Source_id"]):
        axes.annotate(str(name), (x[i], y[i]), xytext=(7, 7), textcoords="offset points", color=BLUE)
    axes.invert_xaxis()
    axes.set_aspect("equal")
    axes.set_xlabel("east [arcmin]")
    axes.set_ylabel("north [arcmin]")
    axes.legend(loc="upper left", frameon=False, bbox_to_anchor=(0, 1.12), ncols=2)


def close_up(axes, row, samples, truth):
    """Posterior samples of the position, and the source's mean shape."""
    centre = (row["RA"], row["DEC"])
    x, y = (60 * v for v in offsets(samples["ra"], samples["dec"], centre))
    rng = np.random.default_rng(1)
    weight = np.array(samples["weight"])
    pick = rng.choice(len(x), 1500, p=weight / weight.sum())
    axes.plot(x[pick], y[pick], ".", ms=1.5, color=BLUE, alpha=0.4)
    pa = 90 + row["PA"]  # the x axis is turned round below
    axes.add_patch(Ellipse((0, 0), row["Maj"], row["Min"], angle=180 - pa, fc="none", ec=GREY))
    if truth is not None:
        tx, ty = (60 * v for v in offsets(truth[0], truth[1], centre))
        axes.plot(tx, ty, "+", color=ORANGE, ms=13, mew=1.5)
    half = max(0.75 * row["Maj"], 5 * row["E_RA"])
    axes.set_xlim(half, -half)
    axes.set_ylim(-half, half)
    axes.set_aspect("equal")
    axes.set_title(f"source {row['Source_id']}: {row['Total_flux']:.0f} ± {row['E_Total_flux']:.0f} µJy")
    axes.set_xlabel("east [arcsec]")


def main():
    out, picture = sys.argv[1:3]
    table = Table.read(out, hdu="CATALOGUE")
    posterior = Table.read(out.replace(".fits", ".posterior.fits"), hdu="POSTERIOR")
    truth = None
    if len(sys.argv) > 3:
        with open(sys.argv[3], newline="") as file:
            rows = list(csv.DictReader(file))
        truth = np.array([[float(r["RA[deg]"]), float(r["DEC[deg]"])] for r in rows]).T
    centre = (np.mean(table["RA"]), np.mean(table["DEC"]))
    figure = plt.figure(figsize=(11, 5.2), layout="constrained")
    grid = figure.add_gridspec(2, 4)
    field(figure.add_subplot(grid[:, :2]), table, truth, centre)
    for k in range(min(4, len(table))):
        row = table[k * (len(table) - 1) // 3 if len(table) > 3 else k]
        samples = posterior[row["Post_row"] : row["Post_row"] + row["Post_n"]]
        close_up(figure.add_subplot(grid[k // 2, 2 + k % 2]), row, samples, truth)
    figure.savefig(picture, dpi=110)


if __name__ == "__main__":
    main()
