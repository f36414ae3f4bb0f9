#!/usr/bin/env python3
"""Finds the sources in simulated fields and compares with the truth: the acceptance study.

    study_field.py --array ANTENNAS.csv --seeds 10 [--keep FOLDER] [--search "--fov 10arcmin ..."] \\
        [-- options of make_field.py]

For each seed `make_field.py` writes a field with pyuvdata, vis2cat searches it, and every row is
matched with the nearest source within three sigma of its position, at least one arcsecond; a source is
matched once. For all seeds together come the mean and root mean square of the pulls,
(estimate - truth) / error, which should be 0 and 1. Exit status 1 if a source is missed or a row is
false. Needs pyuvdata, astropy and numpy, and a release build.
"""

import argparse
import pathlib
import shlex
import subprocess
import sys
import tempfile
import time

import numpy as np
from astropy.table import Table

ROOT = pathlib.Path(__file__).resolve().parent.parent
FLOOR_ARCSEC = 1.0
PULLS = ("RA", "DEC", "Total_flux", "Scale_length", "E1", "E2")


def arguments():
    ours, theirs = sys.argv[1:], []
    if "--" in ours:
        at = ours.index("--")
        ours, theirs = ours[:at], ours[at + 1:]
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--array", required=True, help="CSV with name,x_m,y_m,z_m,diameter_m")
    parser.add_argument("--seeds", type=int, default=5, help="fields to make")
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--search", default="--fov 10arcmin --flux 20uJy:500uJy",
                        help="options of vis2cat, as one word")
    parser.add_argument("--program", type=pathlib.Path, default=ROOT / "target/release/vis2cat")
    parser.add_argument("--keep", type=pathlib.Path, help="folder for the files")
    args = parser.parse_args(ours)
    args.field = theirs
    return args


def offsets_arcsec(rows, truth):
    """East and north of every truth, as seen from every row: (row, truth)."""
    east = (rows["RA"][:, None] - truth["RA"][None, :] + 180) % 360 - 180
    north = rows["DEC"][:, None] - truth["DEC"][None, :]
    return 3600 * east * np.cos(np.deg2rad(truth["DEC"]))[None, :], 3600 * north


def match(rows, truth):
    """Pairs (row, truth), the closest first, each of both at most once."""
    east, north = offsets_arcsec(rows, truth)
    distance = np.hypot(east, north)
    radius = np.maximum(3 * np.hypot(rows["E_RA"], rows["E_DEC"]), FLOOR_ARCSEC)
    pairs = []
    for flat in np.argsort(distance, axis=None):
        i, j = np.unravel_index(flat, distance.shape)
        taken = any(i == row or j == source for row, source in pairs)
        if distance[i, j] <= radius[i] and not taken:
            pairs.append((i, j))
    return pairs


def pulls(rows, truth, pairs):
    """(estimate - truth) / error of every pair: (pair, parameter)."""
    east, north = offsets_arcsec(rows, truth)
    table = []
    for i, j in pairs:
        row = [east[i, j] / rows["E_RA"][i], north[i, j] / rows["E_DEC"][i]]
        row += [(rows[k][i] - truth[k][j]) / rows[f"E_{k}"][i] for k in PULLS[2:]]
        table.append(row)
    return np.array(table).reshape(-1, len(PULLS))


def columns(table, names):
    return {name: np.array(table[name], dtype=float) for name in names}


def study(args, seed, folder):
    """Makes and searches one field; the numbers of found, missed and false, and the pulls."""
    data, sky, out = (folder / f"seed{seed}{suffix}" for suffix in (".uvfits", ".csv", ".fits"))
    make = [sys.executable, ROOT / "scripts/make_field.py", data, sky, "--array", args.array,
            "--seed", str(seed), *args.field]
    made = subprocess.run(make, capture_output=True, text=True, check=False)
    if made.returncode:
        sys.exit(made.stderr)
    start = time.monotonic()
    search = [args.program, data, out, "--overwrite", "--quiet", *shlex.split(args.search)]
    subprocess.run(search, check=True)
    seconds = time.monotonic() - start
    table = Table.read(sky, format="ascii.csv")
    table.rename_columns(table.colnames, [name.split("[")[0] for name in table.colnames])
    truth = columns(table, (*PULLS, "SNR"))
    rows = columns(Table.read(out, hdu=1), (*PULLS, *(f"E_{k}" for k in PULLS), "SNR"))
    pairs = match(rows, truth)
    found = {j for _, j in pairs}
    missed = [j for j in range(len(table)) if j not in found]
    false = [i for i in range(len(rows["RA"])) if i not in {row for row, _ in pairs}]
    print(f"seed {seed}: {len(pairs)} found, {len(missed)} missed, {len(false)} false, {seconds:.1f} s",
          flush=True)
    for j in missed:
        print(f"  missed: {truth['RA'][j]:.6f} {truth['DEC'][j]:+.6f}, {truth['Total_flux'][j]:.0f} uJy, "
              f"SNR {truth['SNR'][j]:.1f}")
    for i in false:
        print(f"  false: {rows['RA'][i]:.6f} {rows['DEC'][i]:+.6f}, {rows['Total_flux'][i]:.0f} uJy, "
              f"SNR {rows['SNR'][i]:.1f}")
    return len(pairs), len(missed), len(false), pulls(rows, truth, pairs)


def main():
    args = arguments()
    with tempfile.TemporaryDirectory() as scratch:
        folder = args.keep or pathlib.Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        seeds = range(args.first_seed, args.first_seed + args.seeds)
        results = [study(args, seed, folder) for seed in seeds]
    found, missed, false = (sum(result[k] for result in results) for k in range(3))
    print(f"all: {found} found, {missed} missed, {false} false")
    table = np.concatenate([result[3] for result in results])
    if len(table):
        print(f"{'pull':>14} {'mean':>7} {'rms':>6} {'largest':>8}")
        for name, column in zip(PULLS, table.T):
            rms = np.sqrt(np.mean(column**2))
            print(f"{name:>14} {column.mean():7.2f} {rms:6.2f} {np.abs(column).max():8.2f}")
    return 1 if missed or false else 0


if __name__ == "__main__":
    sys.exit(main())
