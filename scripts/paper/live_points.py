"""Single runs over the whole field: how many modes are kept, and how many of the galaxies, for each number of live points."""

import json
import shlex
import subprocess

import numpy as np
from astropy.table import Table

from study_simulated import timed


def run(case, args, folder):
    """A row for each number of sources and of live points, and of the search by tiles if there is to be one."""
    rows = []
    for n_source in case["sources"]:
        data, truth = folder / f"n{n_source}.uvfits", folder / f"n{n_source}.truth.fits"
        subprocess.run([args.program, "simulate", data, "--truth", truth, "--sources", str(n_source), "--overwrite",
                        "--quiet", *shlex.split(case["simulate"])], check=True)
        searches = {str(n_live): f"{case['search']} --n-live {n_live}" for n_live in case["n_live"]}
        if "beside" in case:
            searches["tiles"] = case["beside"]
        for name, options in searches.items():
            row = searched(args, data, truth, folder / f"n{n_source}.{name}.fits", options, case["cuts_ujy"])
            rows.append({"n_source": n_source, "n_live": name} | row)
            print(rows[-1], flush=True)
    return {"rows": rows}


def searched(args, data, truth, out, options, cuts_ujy):
    threads = ["--threads", str(args.threads)] if args.threads else []
    seconds, cpu_seconds, megabytes = timed(
        [args.program, data, out, "--overwrite", "--quiet", *shlex.split(options), *threads])
    evaluated = json.loads(subprocess.run([args.program, "evaluate", "--json", out, truth], capture_output=True,
                                          text=True, check=True).stdout)
    run = {str(row["KEY"]).strip(): str(row["VALUE"]).strip() for row in Table.read(out, hdu="RUN")}
    modes, rows = Table.read(out, hdu="MODES"), Table.read(out, hdu="CATALOGUE")
    status = np.array([str(s).strip() for s in modes["Status"]])
    # What the paper keeps: modes that are better than no source, each once.
    flux_ujy = np.array(modes["Total_flux"])[np.isin(status, ["kept", "below_cut", "explained_by_brighter"])]
    row_flux_ujy = np.array(rows["Total_flux"])
    is_true = np.isin(np.arange(len(rows)) + 1, [pair["row"] for pair in evaluated["matched"]])
    return {
        "found": len(evaluated["matched"]), "false": len(evaluated["false_rows"]), "modes": len(modes),
        "seconds": seconds, "cpu_seconds": cpu_seconds, "megabytes": megabytes,
        "n_eval": int(run["search.n_eval"]), "n_sample": int(run["data.n_sample"]),
        "modes_above": {str(cut): int((flux_ujy >= cut).sum()) for cut in cuts_ujy},
        "true_above": {str(cut): int((is_true & (row_flux_ujy >= cut)).sum()) for cut in cuts_ujy},
    }
