#!/usr/bin/env python3
"""Compare the counts of `vis2cat info --json` with pyuvdata's, or casacore's for sets pyuvdata cannot read.

    check_info.py --target target/release FILE...

Prints a line a file; the exit code is 1 if any differ.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import warnings

import numpy as np

warnings.simplefilter("ignore")
import logging  # noqa: E402

logging.disable(logging.WARNING)


def by_pyuvdata(path):
    from pyuvdata import UVData

    data = UVData()
    data.read(str(path), run_check=False)
    pairs = {tuple(sorted(pair)) for pair in zip(data.ant_1_array, data.ant_2_array)}
    n_antenna = len({int(a) for pair in pairs for a in pair})
    return {
        "rows": int(data.Nblts),
        "autocorrelations": int((data.ant_1_array == data.ant_2_array).sum()),
        "baselines": len(pairs),
        "antennas used": n_antenna,
        "antennas": int(data.telescope.Nants),
        # pyuvdata takes a phase centre for unprojected data too.
        "fields": int(data.Nphase),
        "times": len(np.unique(np.round(data.time_array * 86400e3))),
        "channels": int(data.Nfreqs),
        "windows": int(data.Nspws),
        "correlations": int(data.Npols),
        "flagged": int((data.flag_array | (data.nsample_array <= 0)).sum())
        if (data.nsample_array > 0).any() else int(data.flag_array.sum()),
        "first": round(float(data.time_array.min() - 2400000.5), 6),
    }


def by_casacore(path):
    from casacore.tables import table

    main = table(str(path), ack=False)
    sub = lambda name: table(f"{path}/{name}", ack=False)
    ants = np.array([main.getcol("ANTENNA1"), main.getcol("ANTENNA2")])
    flags = main.getcol("FLAG") | main.getcol("FLAG_ROW")[:, None, None]
    name = "WEIGHT_SPECTRUM" if "WEIGHT_SPECTRUM" in main.colnames() and main.iscelldefined("WEIGHT_SPECTRUM", 0) else "WEIGHT"
    weights = main.getcol(name)
    flags = flags | ((weights if weights.ndim == 3 else weights[:, None, :]) <= 0)
    time = main.getcol("TIME")
    real = [n for n, x in zip(sub("ANTENNA").getcol("NAME"), sub("ANTENNA").getcol("POSITION")) if n or x.any()]
    return {
        "rows": main.nrows(),
        "autocorrelations": int((ants[0] == ants[1]).sum()),
        "baselines": len({tuple(sorted(pair)) for pair in ants.T}),
        "antennas used": len(np.unique(ants)),
        "antennas": len(real),
        "fields": sub("FIELD").nrows(),
        "times": len(np.unique(np.round(time * 1e3))),
        "channels": main.getcell("DATA", 0).shape[0],
        "windows": len(np.unique(main.getcol("DATA_DESC_ID"))),
        "correlations": main.getcell("DATA", 0).shape[1],
        "flagged": int(flags.sum()),
        "first": round(float(time.min() / 86400), 6),
    }


def by_us(binary, path):
    done = subprocess.run([binary, "info", path, "--json", "--quiet"], capture_output=True, text=True)
    if done.returncode:
        return {"error": done.stderr.strip()}
    info = json.loads(done.stdout)
    seen = info["observation"]
    setups = seen["freq_setups"]
    uvh5 = seen["uvh5"]
    return {
        "rows": info["n_row"],
        "autocorrelations": info["n_row_auto"],
        "baselines": info["n_baseline"],
        "antennas used": info["n_antenna_used"],
        "antennas": len(seen["antennas"]),
        "fields": len(seen["fields"]),
        "times": info["n_time"],
        "channels": sum(len(setup["freq_hz_f"]) for setup in setups),
        "windows": len(set(uvh5["spw_f"])) if uvh5 else sum(setup["n_if"] for setup in setups),
        "correlations": len(seen["corrs"]),
        "flagged": info["n_flagged"],
        "first": round(info["first_mjd"], 6),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--target", type=pathlib.Path, default=pathlib.Path("target/release"))
    parser.add_argument("files", nargs="+", type=pathlib.Path)
    arguments = parser.parse_args()
    is_bad = False
    for path in arguments.files:
        ours = by_us(arguments.target / "vis2cat", path)
        theirs, by = None, "pyuvdata"
        try:
            theirs = by_pyuvdata(path)
        except Exception as error:
            if path.is_dir():
                theirs, by = by_casacore(path), "casacore"
            else:
                print(f"{path.name}: pyuvdata: {error}")
                continue
        differ = {key: (ours.get(key), value) for key, value in theirs.items() if ours.get(key) != value}
        is_bad |= bool(differ)
        words = "agrees" if not differ else f"ours, theirs: {differ} {ours.get('error', '')}"
        print(f"{path.name} ({by}, {theirs['rows']} rows, {theirs['channels']} channels): {words}")
    return int(is_bad)


if __name__ == "__main__":
    sys.exit(main())
