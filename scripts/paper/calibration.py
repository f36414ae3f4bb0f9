"""Simulation-based calibration: ranks of the truth among the posterior samples, which must be uniform.

Source: Talts et al. 2018, arXiv:1804.06788; with weighted samples the rank is the weight below the truth.
"""

import shlex
import subprocess

import numpy as np
from astropy.table import Table
from scipy.stats import chisquare

# Column of the posterior samples and of the truth.
PARAMETERS = {"RA": ("ra", "RA"), "DEC": ("dec", "DEC"), "Total_flux": ("flux", "Total_flux"),
              "Scale_length": ("scale", "Scale_length"), "E1": ("e1", "E1"), "E2": ("e2", "E2")}
LEVELS = (0.50, 0.68, 0.95)


def run(case, args, folder):
    """The ranks of every parameter in bins, and how often intervals hold the truth."""
    threads = ["--threads", str(args.threads)] if args.threads else []
    ranks, left_out = [], []
    for seed in range(1, case["n_source"] + 1):
        rank = ranks_of_one(case, args.program, folder, seed, threads)
        if rank is None:
            left_out.append(seed)
        else:
            ranks.append(rank)
        if seed % 50 == 0:
            print(f"{seed} sources", flush=True)
    parameters = [calibrated(name, np.array(column), case["n_bin"])
                  for name, column in zip(PARAMETERS, np.array(ranks).T)]
    for parameter in parameters:
        print(parameter)
    return {"n_source": len(ranks), "not_one_row": left_out, "parameters": parameters}


def ranks_of_one(case, program, folder, seed, threads):
    """Weight of the samples below the truth for each parameter; none if not one row came out."""
    data, truth, out = (folder / name for name in ("field.uvfits", "truth.fits", "out.fits"))
    common = ["--seed", str(seed), "--quiet", "--overwrite", *threads]
    subprocess.run([program, "simulate", data, "--truth", truth, *shlex.split(case["simulate"]), *common], check=True)
    subprocess.run([program, data, out, *shlex.split(case["search"]), *common], check=True)
    if len(Table.read(out, hdu="CATALOGUE")) != 1:
        return None
    samples, source = Table.read(out.with_suffix(".posterior.fits"), hdu=1), Table.read(truth)[0]
    weight = np.array(samples["weight"])
    return [weight[np.array(samples[column]) < source[true]].sum() / weight.sum()
            for column, true in PARAMETERS.values()]


def calibrated(name, rank, n_bin):
    counts, _ = np.histogram(rank, bins=n_bin, range=(0, 1))
    covered = {f"{level:.2f}": int((np.abs(rank - 0.5) < level / 2).sum()) for level in LEVELS}
    return {"name": name, "n": len(rank), "counts": counts.tolist(), "covered": covered,
            "p_value": float(chisquare(counts).pvalue)}
