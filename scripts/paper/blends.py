"""Galaxies that overlap: are all found, and are their errors, joint ones, right?"""

import numpy as np

import study_blends


def run(case, args, folder):
    """Pulls and chi square for each kind of blend of `study_blends.py`."""
    rows = []
    for name, n_seed in case["seeds"].items():
        pulls, _, chi2, joint = study_blends.study(str(args.program), name, range(1, n_seed + 1), folder)
        rows.append({
            "name": name, "blends": n_seed, "all_found": len(pulls), "sampled_jointly": joint,
            "rms_pull": float(np.sqrt((pulls**2).mean())), "largest_pull": float(np.abs(pulls).max()),
            "chi2": float(chi2.mean()), "chi2_err": float(chi2.std() / np.sqrt(len(chi2))),
            "parameters": int(pulls[0].size),
        })
        print(rows[-1], flush=True)
    return {"rows": rows}
