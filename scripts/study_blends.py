#!/usr/bin/env python3
"""Are the errors of overlapping galaxies right? Blends of galaxies under many realisations of the noise.

    study_blends.py --seeds 20 [--case NAME] [--program PATH ...]

Each case is simulated and searched once a seed by every program given (say, builds with and without
joint sampling). From the posterior samples come, for each galaxy, the pulls (mean - truth) / error of
position, flux density, ln scale-length and ellipticity, whose root mean square should be 1; and for all
together the chi square of their parameters with their joint covariance, whose mean should be their number
(members of different groups count as independent). Needs astropy and numpy, and a release build.
"""

import argparse
import pathlib
import shlex
import subprocess
import sys
import tempfile

import numpy as np
from astropy.table import Table

ROOT = pathlib.Path(__file__).resolve().parent.parent
ARCSEC = 3600.0
NAMES = ("east", "north", "flux", "ln scale", "e1", "e2")
# Name: options of simulate, options of the search, rows of RA, DEC, flux, scale, e1, e2.
CASES = {
    "equal": (
        "--array vla-a --tint 20min --sefd 20Jy",
        "--fov 30arcsec --flux 5uJy:500uJy",
        [(53.1183173, -30.325, 30, 0.8, 0.2, 0.1), (53.1192827, -30.325, 30, 0.7, -0.1, 0.15)],
    ),
    "unequal": (
        "--array ska1-mid --tint 1h --sefd 150Jy",
        "--fov 1arcmin --flux 3uJy:500uJy",
        [(53.1188, -30.325, 200, 2.3, 0.2, 0.1), (53.12202, -30.325, 10, 0.8, -0.1, 0.15)],
    ),
    "row of five": (
        "--array vla-a --tint 20min --sefd 20Jy",
        "--fov 40arcsec --flux 5uJy:500uJy",
        [(53.1188 + 0.00095 * k, -30.325 + 0.0002 * (-1) ** k, 40 - 4 * k, 0.9 - 0.05 * k, 0.2 - 0.1 * k, 0.1)
         for k in range(-2, 3)],
    ),
}


def run(program, arguments):
    subprocess.run([program, *shlex.split(arguments)], check=True, capture_output=True)


def posterior(out, truth):
    """Samples about the truth, axes (sample, parameter), weights and group of each row of a catalogue."""
    samples = Table.read(out.with_suffix(".posterior.fits"))
    members = []
    for row in Table.read(out, hdu="CATALOGUE"):
        slice_ = samples[row["Post_row"]: row["Post_row"] + row["Post_n"]]
        distance = [np.hypot(row["RA"] - s[0], row["DEC"] - s[1]) for s in truth]
        which = int(np.argmin(distance))
        ra, dec, flux, scale, e1, e2 = truth[which]
        east = (slice_["ra"] - ra) * np.cos(np.radians(dec)) * ARCSEC
        offsets = (east, (slice_["dec"] - dec) * ARCSEC, slice_["flux"] - flux,
                   np.log(slice_["scale"] / scale), slice_["e1"] - e1, slice_["e2"] - e2)
        members.append((which, row["Group_id"], np.array(slice_["weight"]), np.stack(offsets, 1)))
    return sorted(members, key=lambda member: member[0])


def moments(weight, offsets):
    mean = weight @ offsets
    return mean, (offsets - mean).T * weight @ (offsets - mean)


def chi_square(members):
    """Of all parameters of all members, in their joint covariance where they have one; the largest group."""
    total, largest = 0.0, 0
    for group in {member[1] for member in members}:
        together = [member for member in members if member[1] == group]
        mean, covariance = moments(together[0][2], np.hstack([member[3] for member in together]))
        total += mean @ np.linalg.solve(covariance, mean)
        largest = max(largest, len(together))
    return total, largest


def study(program, case, seeds, folder):
    """Pulls and errors, axes (blend, galaxy, parameter), chi square of each blend, and how many were sampled jointly."""
    simulation, search, truth = CASES[case]
    sky = folder / "sky.csv"
    rows = "".join(",".join(map(str, source)) + "\n" for source in truth)
    sky.write_text("RA,DEC,Total_flux,Scale_length,E1,E2\n" + rows)
    pulls, errors, chi2, joint = [], [], [], 0
    for seed in seeds:
        data, out = folder / "field.uvfits", folder / "out.fits"
        run(program, f"simulate {data} --ra 53.1188deg --dec -30.325deg --catalogue {sky} "
                     f"--seed {seed} --overwrite {simulation}")
        run(program, f"{data} {out} --overwrite {search}")
        members = posterior(out, truth)
        if [member[0] for member in members] != list(range(len(truth))):
            print(f"  seed {seed}: found {[member[0] for member in members]}", flush=True)
            continue
        of_each = [moments(member[2], member[3]) for member in members]
        error = np.array([np.sqrt(np.diag(covariance)) for _, covariance in of_each])
        pulls.append(np.array([mean for mean, _ in of_each]) / error)
        errors.append(error)
        chi2_of_all, largest = chi_square(members)
        chi2.append(chi2_of_all)
        joint += largest == len(truth)
    return np.array(pulls), np.array(errors), np.array(chi2), joint


def report(program, case, pulls, errors, chi2, joint):
    n = len(pulls)
    print(f"{case}, {program}: {n} blends, all of {joint} sampled jointly")
    print("  galaxy " + "".join(f"{name:>10}" for name in NAMES))
    for galaxy in range(pulls.shape[1]):
        for title, values in (("rms pull", np.sqrt((pulls[:, galaxy] ** 2).mean(0))),
                              ("mean pull", pulls[:, galaxy].mean(0)),
                              ("mean error", errors[:, galaxy].mean(0))):
            print(f"  {galaxy} {title:>10}" + "".join(f"{value:10.3f}" for value in values))
    rms, scatter = np.sqrt((pulls ** 2).mean()), np.sqrt(0.5 / pulls.size)
    print(f"  rms pull of all {rms:.3f} (1 +- {scatter:.3f} if independent), "
          f"largest {np.abs(pulls).max():.1f}")
    print(f"  chi square of {pulls[0].size} {chi2.mean():.1f} +- {chi2.std() / np.sqrt(n):.1f}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seeds", type=int, default=20, help="realisations of the noise")
    parser.add_argument("--case", action="append", choices=CASES, help="default: all")
    parser.add_argument("--program", action="append", help="default: the release build")
    args = parser.parse_args()
    for case in args.case or CASES:
        for program in args.program or [str(ROOT / "target/release/vis2cat")]:
            with tempfile.TemporaryDirectory() as folder:
                report(program, case, *study(program, case, range(1, args.seeds + 1), pathlib.Path(folder)))


if __name__ == "__main__":
    sys.exit(main())
