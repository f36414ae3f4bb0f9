#!/usr/bin/env python3
"""Opens the chains of `vis2cat --chains` with the programs that they are written for.

Usage: check_chains.py DIR

getdist and anesthetic load every source, and agree with MultiNest's file set about means and errors.
Both come from PyPI: `pip install getdist anesthetic` (400 MB with what they need). One that is not
installed is skipped and said so; exit status 1 if any check fails.
"""

import glob
import importlib.util
import re
import sys

import numpy as np

NAMES = ["l_arcsec", "m_arcsec", "flux_ujy", "scale_arcsec", "e1", "e2"]


def by_numpy(root):
    """Mean and error of each parameter by the plain numbers of the file, weight and -ln L first."""
    chain = np.loadtxt(f"{root}.txt", ndmin=2)
    weight, values = chain[:, 0], chain[:, 2:]
    assert abs(weight.sum() - 1) < 1e-9 and values.shape[1] == len(NAMES)
    mean = weight @ values
    return mean, np.sqrt(weight @ (values - mean) ** 2), chain


def by_getdist(root):
    from getdist import loadMCSamples

    samples = loadMCSamples(root)
    assert [p.name for p in samples.paramNames.names] == NAMES
    assert samples.ranges.getUpper("flux_ujy") > samples.ranges.getLower("flux_ujy") > 0
    return samples.getMeans(), np.sqrt(samples.getVars())


def by_anesthetic(root):
    from anesthetic import read_chains

    samples = read_chains(root)
    values = samples[NAMES]
    assert len(samples) > 0 and np.isfinite(samples["logL"]).all()
    return values.mean().to_numpy(), values.std(ddof=0).to_numpy()


def by_multinest_files(root, chain):
    """MultiNest's set, read as its README says."""
    twice = np.loadtxt(f"{root}-.txt", ndmin=2)
    assert np.allclose(twice[:, 1], 2 * chain[:, 1]) and np.array_equal(twice[:, 2:], chain[:, 2:])
    text = open(f"{root}-post_separate.dat").read()
    modes = [mode for mode in re.split(r"\n\n+", "\n" + text) if mode.strip()]
    assert len(modes) == 1 and len(modes[0].strip().split("\n")) == len(chain)
    equal = np.loadtxt(f"{root}-post_equal_weights.dat", ndmin=2)
    assert set(equal[:, -1]) <= set(-chain[:, 1])
    error = chain[:, 0] @ (chain[:, 2:] - chain[:, 0] @ chain[:, 2:]) ** 2
    off = (equal[:, :-1].mean(axis=0) - chain[:, 0] @ chain[:, 2:]) / np.sqrt(error)
    assert abs(off).max() < 5 / np.sqrt(len(equal)), off
    tables = open(f"{root}-stats.dat").read().split("Dim No.")
    assert "Total Modes Found:  1" in tables[0] and len(tables) == 4
    rows = np.array([line.split() for line in tables[1].split("\n")[1:7]], float)
    return rows[:, 1], rows[:, 2]


def main(folder):
    roots = [path[:-5] for path in glob.glob(f"{folder}/source_*-.txt")]
    if not roots:
        sys.exit(f"no chains in {folder}")
    readers = {"getdist": by_getdist, "anesthetic": by_anesthetic}
    for name in [name for name in readers if importlib.util.find_spec(name) is None]:
        print(f"SKIPPED: {name} is not installed")
        del readers[name]
    for root in sorted(roots):
        mean, error, chain = by_numpy(root)
        read = {"multinest": by_multinest_files(root, chain)}
        read |= {name: reader(root) for name, reader in readers.items()}
        for name, (its_mean, its_error) in read.items():
            assert np.allclose((its_mean - mean) / error, 0, atol=1e-6), (name, root)
            assert np.allclose(its_error, error, rtol=1e-5), (name, root)
            print(f"ok {name} {root}")


if __name__ == "__main__":
    main(*sys.argv[1:])
