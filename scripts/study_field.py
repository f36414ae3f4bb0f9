#!/usr/bin/env python3
"""Finds the sources in simulated fields and compares with the truth: the acceptance study.

    study_field.py --array ANTENNAS.csv --seeds 10 [--keep FOLDER] [--search "--fov 10arcmin ..."] \\
        [-- options of make_field.py]

For each seed `make_field.py` writes a field with pyuvdata, vis2cat searches it, and `vis2cat evaluate`
compares the catalogue with the truth. For all seeds together come the mean and root mean square of the
pulls, (estimate - truth) / error, which should be 0 and 1. Exit status 1 if a source is missed or a row
is false. Needs pyuvdata, astropy and numpy, and a release build.
"""

import argparse
import json
import pathlib
import shlex
import subprocess
import sys
import tempfile
import time

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
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
    evaluated = subprocess.run([args.program, "evaluate", "--json", out, sky],
                               capture_output=True, text=True, check=True)
    result = json.loads(evaluated.stdout)
    matched, missed, false = (result[key] for key in ("matched", "missed", "false_rows"))
    print(f"seed {seed}: {len(matched)} found, {len(missed)} missed, {len(false)} false, "
          f"{seconds:.1f} s", flush=True)
    for name, sources in (("missed", missed), ("false", false)):
        for source in sources:
            print(f"  {name}: {source['ra_deg']:.6f} {source['dec_deg']:+.6f}, "
                  f"{source['flux_ujy']:.0f} uJy, SNR {source['snr']:.1f}")
    pulls = np.array([row["pulls"] for row in matched], dtype=float)
    return len(matched), len(missed), len(false), pulls.reshape(-1, len(PULLS))


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
