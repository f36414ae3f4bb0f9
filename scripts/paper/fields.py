"""Fields that are simulated, searched and compared with the truth: a row of the result for each seed."""

import types

import numpy as np

import study_simulated
from oracle import oracle_snr

# What `vis2cat evaluate --json` says of a field that is kept for each seed.
OF_SEED = ("seed", "n_sample", "n_eval", "seconds", "cpu_seconds", "megabytes", "n_negative")


def run(case, args, folder):
    """Counts for each seed of a case, and pulls of all galaxies."""
    threads = f" --threads {args.threads}" if args.threads else ""
    study = types.SimpleNamespace(program=args.program, simulate=case["simulate"], starts=None)
    results = []
    for seed in case["seeds"]:
        results.append(field(study, case, seed, folder, case["search"] + threads))
        if not args.keep:
            (folder / f"seed{seed}.uvfits").unlink()
    parameters = [pulls(results, i) for i in range(len(results[0].get("parameters", [])))]
    return {"seeds": [of_seed(result) for result in results], "parameters": [p for p in parameters if p["n"]]}


def field(study, case, seed, folder, options):
    evaluated = study_simulated.study(study, seed, folder, options, "")
    if case.get("oracle"):
        evaluated["oracle"] = oracle_snr(folder / f"seed{seed}.uvfits", folder / f"seed{seed}.truth.fits")
    return evaluated


def of_seed(result):
    row = {key: result[key] for key in OF_SEED}
    row |= {"found": len(result["matched"]), "missed": len(result["missed"]), "false": result["n_false"]}
    row["missed_snr"] = [round(source["snr"], 2) for source in result["missed"]]
    curves = {curve["score"]: curve for curve in result.get("curves", [])}
    if "SNR_peak" in curves:
        row["roc_area"] = curves["SNR_peak"]["area"]
        row["log_z_roc_area"] = curves["Log_Z"]["area"]
        clean = curves["SNR_peak"]["lowest_without_false"]
        if clean:
            row["clean"] = {"cut": clean["cut"], "n_true": clean["n_true"]}
            for key in ("completeness", "completeness_snr_5"):
                row["clean"][key] = [clean[key]["n"], clean[key]["of"]]
            if "oracle" in result:
                seen = [snr for snr, true in result["oracle"] if true >= 5]
                row["clean"]["oracle_snr_5"] = [sum(snr >= clean["cut"] for snr in seen), len(seen)]
    return row


def pulls(results, i):
    """Pulls and coverage of parameter `i` over all seeds."""
    of = [result["parameters"][i] for result in results if "parameters" in result]
    values = np.array([m["pulls"][i] for r in results for m in r["matched"] if m["pulls"][i] is not None], float)
    strong = [m["pulls"][i] for r in results for m in r["matched"]
              if m["pulls"][i] is not None and (m["true_snr"] or 0) >= 10]
    row = {"name": of[0]["name"], "n": len(values)}
    if len(values):
        row |= {"mean": values.mean(), "mean_err": values.std() / np.sqrt(len(values)),
                "rms": np.sqrt((values**2).mean()), "largest": np.abs(values).max(),
                "n_snr_10": len(strong), "beyond_5_snr_10": sum(abs(pull) > 5 for pull in strong)}
        for k, level in enumerate(("in_68", "in_95")):
            covered = [parameter["coverage"][k]["covered"] for parameter in of if len(parameter["coverage"]) > k]
            row[level] = [sum(c["n"] for c in covered), sum(c["of"] for c in covered)]
    return row
