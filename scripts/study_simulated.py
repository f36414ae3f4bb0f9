#!/usr/bin/env python3
"""Finds the sources in fields of `vis2cat simulate` and compares with the truth, many fields in one table.

    study_simulated.py --simulate "--array ska1-mid --sources 100 --sefd 400Jy" --search "--memory 512MB"
    study_simulated.py --simulate "--array meerkat --sources 30 --channels 64 --bandwidth 856MHz --tint 8s
        --hours 0.0022222222 --smearing --beam meerkat" --starts 2020-01-01T18:00:00 2020-01-01T21:00:00
        --search "--smearing --beam meerkat"

Per field: what was found, missed and false, wall time, peak memory and likelihood evaluations. For all
fields together: the pulls, (estimate - truth) / error, which should have mean 0 and rms 1; the parts of
the truths that lie in the 68% and 95% intervals; how many of the modes of each probability P_source are
true; and how many false rows and negative peaks there were. With `--starts` a field is a file for each of
them, searched together: few integrations spread in hour angle. `--also` searches the same fields again with
other options. `docs/studies.md` has results. Needs numpy,
astropy, GNU time and a release build.
"""

import argparse
import json
import pathlib
import shlex
import subprocess
import sys
import tempfile

import numpy as np
from astropy.table import Table

ROOT = pathlib.Path(__file__).resolve().parent.parent


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--simulate", required=True, help="options of vis2cat simulate, as one word")
    parser.add_argument("--search", default="", help="options of vis2cat, as one word")
    parser.add_argument("--also", help="options of a second search of the same fields, as one word")
    parser.add_argument("--starts", nargs="+", help="start (UTC) of each part of an observation")
    parser.add_argument("--seeds", type=int, default=3, help="fields to make")
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--program", type=pathlib.Path, default=ROOT / "target/release/vis2cat")
    parser.add_argument("--keep", type=pathlib.Path, help="folder for the catalogues, and for fields to use again")
    return parser.parse_args()


def timed(command):
    """Runs a command; wall seconds, CPU seconds and peak memory [MB]."""
    done = subprocess.run(["/usr/bin/env", "time", "-f", "%e %U %S %M", *command], capture_output=True, text=True)
    if done.returncode:
        sys.exit(done.stderr)
    seconds, user, system, kilobytes = map(float, done.stderr.split()[-4:])
    return seconds, user + system, kilobytes / 1e3


def log_scale_pulls(out, truth, matched):
    """(mean - truth) / error of ln alpha, by the posterior samples of each matched row."""
    rows, samples = Table.read(out, hdu=1), Table.read(out.with_suffix(".posterior.fits"), hdu=1)
    true_scale = Table.read(truth)["Scale_length"]
    pulls = []
    for pair in matched:
        row = rows[pair["row"] - 1]
        own = samples[row["Post_row"]:row["Post_row"] + row["Post_n"]]
        weight, value = np.array(own["weight"]), np.log(np.array(own["scale"]))
        mean = np.average(value, weights=weight)
        error = np.sqrt(np.average((value - mean) ** 2, weights=weight))
        pulls.append((mean - np.log(true_scale[pair["truth_row"] - 1])) / error)
    return pulls


def simulated(args, seed, folder):
    """The files of one field and the table of its sources; made unless they are there."""
    truth = folder / f"seed{seed}.truth.fits"
    data = folder / f"seed{seed}.uvfits"
    make = [args.program, "simulate", data, "--truth", truth, "--seed", str(seed), "--quiet", "--overwrite"]
    if not data.exists():
        subprocess.run([*make, *shlex.split(args.simulate)], check=True)
    if not args.starts:
        return [data], truth
    # The same sky at each start, with other noise; the ratios of the parts add in squares.
    options = shlex.split(args.simulate)
    at = options.index("--sources")
    options[at:at + 2] = ["--catalogue", str(truth)]
    parts, snr2 = [], 0.0
    for i, start in enumerate(args.starts):
        part, seen = folder / f"seed{seed}.{i}.uvfits", folder / f"seed{seed}.{i}.truth.fits"
        if not part.exists():
            subprocess.run([args.program, "simulate", part, "--truth", seen, "--start", start, "--seed",
                            str(1000 * seed + i), "--quiet", "--overwrite", *options], check=True)
        parts.append(part)
        snr2 = snr2 + np.array(Table.read(seen)["SNR"]) ** 2
    table = Table.read(truth)
    table["SNR"] = np.sqrt(snr2)
    table.write(truth, overwrite=True)
    return parts, truth


def study(args, seed, folder, options, name):
    """Makes and searches one field; what `vis2cat evaluate --json` says, with pulls of ln alpha."""
    data, truth = simulated(args, seed, folder)
    out = folder / f"seed{seed}{name}.fits"
    search = [args.program, *data, out, "--overwrite", "--quiet", *shlex.split(options)]
    seconds, cpu_seconds, megabytes = timed(search)
    run = {str(row["KEY"]).strip(): str(row["VALUE"]).strip() for row in Table.read(out, hdu="RUN")}
    result = {"seed": seed, "rows": len(Table.read(out, hdu=1)), "matched": [], "seconds": seconds,
              "cpu_seconds": cpu_seconds, "megabytes": megabytes, "n_sample": int(run["data.n_sample"]),
              "n_eval": int(run["search.n_eval"])}
    if len(Table.read(truth)):
        evaluated = subprocess.run([args.program, "evaluate", "--json", out, truth],
                                   capture_output=True, text=True, check=True)
        result |= json.loads(evaluated.stdout)
        result["log_scale"] = log_scale_pulls(out, truth, result["matched"])
        result["n_false"] = len(result["false_rows"])
    else:
        result |= {"missed": [], "n_false": result["rows"]}
    result["n_negative"] = int(run.get("search.n_negative", 0))
    print(f"seed {seed}: {len(result['matched'])} found, {len(result['missed'])} missed, {result['n_false']} false, "
          f"{run.get('search.n_negative', '-')} negative peaks; {run['data.n_sample']} visibilities, "
          f"{seconds:.1f} s, {megabytes:.0f} MB, {float(run['search.n_eval']) / 1e6:.2f} million evaluations", flush=True)
    for source in result["missed"]:
        print(f"  missed: {source['ra_deg']:.6f} {source['dec_deg']:+.6f}, SNR {source['snr']:.1f}")
    return result


def pull_table(results):
    names = [parameter["name"] for parameter in results[0]["parameters"]]
    pulls = np.array([pair["pulls"] for r in results for pair in r["matched"]], dtype=float)
    columns = dict(zip(names, pulls.T)) | {"ln alpha": np.concatenate([r["log_scale"] for r in results])}
    print(f"{'':>14} {'mean':>12} {'rms':>6} {'largest':>8} {'> 5':>4}   in 68%   in 95%")
    for name, column in columns.items():
        inside = ["", ""]
        for k in range(2):
            counts = [p["coverage"][k]["covered"] for r in results for p in r["parameters"] if p["name"] == name]
            if counts:
                inside[k] = f"{sum(c['n'] for c in counts) / sum(c['of'] for c in counts):.3f}"
        error = column.std() / np.sqrt(len(column))
        print(f"{name:>14} {column.mean():6.2f}±{error:.2f} {np.sqrt(np.mean(column**2)):6.2f} "
              f"{np.abs(column).max():8.2f} {np.sum(np.abs(column) > 5):4d}   {inside[0]:>6}   {inside[1]:>6}")


def reliability_table(results):
    print("P_source          modes   mean P   true part")
    for k, first in enumerate(results[0]["reliability"]):
        bins = [r["reliability"][k] for r in results]
        n = sum(b["is_true"]["of"] for b in bins)
        if n:
            mean = sum(b["mean_p"] * b["is_true"]["of"] for b in bins if b["is_true"]["of"]) / n
            true = sum(b["is_true"]["n"] for b in bins) / n
            print(f"{first['low']:.1f} to {first['high']:.1f}  {n:10d}   {mean:.3f}    "
                  f"{true:.3f} ± {np.sqrt(mean * (1 - mean) / n):.3f} expected")


def main():
    args = arguments()
    with tempfile.TemporaryDirectory() as scratch:
        folder = args.keep or pathlib.Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        results, also = [], []
        for seed in range(args.first_seed, args.first_seed + args.seeds):
            results.append(study(args, seed, folder, args.search, ""))
            if args.also is not None:
                also.append(study(args, seed, folder, args.also, ".also"))
            if not args.keep:
                for file in folder.glob(f"seed{seed}.*uvfits"):
                    file.unlink()
        summarise(results)
        if also:
            print(f"\nwith {args.also or 'no options'}:")
            summarise(also)


def summarise(results):
    found, missed, false, negative = (
        sum(len(r[key]) if isinstance(r[key], list) else r[key] for r in results)
        for key in ("matched", "missed", "n_false", "n_negative")
    )
    print(f"all: {found} found, {missed} missed, {false} false, {negative} negative peaks")
    if found:
        pull_table(results)
        reliability_table(results)


if __name__ == "__main__":
    main()
