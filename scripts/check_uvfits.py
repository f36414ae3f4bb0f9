#!/usr/bin/env python3
"""Compare our UVFITS reader and writer with pyuvdata's, both ways.

    check_uvfits.py FILE.uvfits ...

For each file: what our reader decodes must equal what pyuvdata reads; what our writer makes of it
must pass `fitsverify` and pyuvdata's strict checks and equal the original; and pyuvdata's own
re-write, read by us, must equal what it wrote. Build the helpers first:
`cargo build --release -p vis2cat-formats --examples`. Needs pyuvdata >= 3.2 and fitsverify.

pyuvdata holds r(ant2) - r(ant1) and conjugates on reading; we hold what the file holds. So here its
uvw are negated and its data conjugated back.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile
import warnings

import numpy as np
from astropy.utils import iers
from pyuvdata import UVData

iers.conf.auto_download = False
iers.conf.auto_max_age = None
warnings.simplefilter("ignore")

ROOT = pathlib.Path(__file__).resolve().parent.parent
CORR_CODES = {"I": 1, "Q": 2, "U": 3, "V": 4, "RR": -1, "LL": -2, "RL": -3, "LR": -4,
              "XX": -5, "YY": -6, "XY": -7, "YX": -8}


class Ours:
    """What `dump_vis` says about a file."""

    def __init__(self, tools, path, folder):
        out = pathlib.Path(folder) / "dump"
        subprocess.run([tools / "dump_vis", path, out], check=True)
        raw = out.read_bytes()
        end = raw.index(b"\n")
        head = json.loads(raw[:end])
        self.obs = head["observation"]
        n, f, p = head["n_read"], head["n_chan"], head["n_corr"]
        self.offset = end + 1

        def take(dtype, *shape):
            count = int(np.prod(shape))
            array = np.frombuffer(raw, dtype, count, self.offset).reshape(shape)
            self.offset += array.nbytes
            return array

        self.n_row = n
        self.uvw_m = take("<f8", n, 3)
        self.time_mjd = take("<f8", n)
        self.interval_s = take("<f8", n)
        self.ant1, self.ant2 = take("<u4", n), take("<u4", n)
        self.field, self.setup = take("<u4", n), take("<u4", n)
        self.vis = take("<c8", n, f, p)
        self.weight = take("<f4", n, f, p)
        self.flag = take("u1", n, f, p).astype(bool)
        assert self.offset == len(raw)


class Check:
    """Counts what agrees and prints what does not."""

    def __init__(self, name):
        self.name, self.bad = name, 0

    def ok(self, what, good, note=""):
        if not good:
            self.bad += 1
            print(f"  DIFFERS {self.name}: {what} {note}")

    def close(self, what, a, b, atol, rtol=0.0):
        a, b = np.asarray(a), np.asarray(b)
        good = a.shape == b.shape and np.allclose(a, b, atol=atol, rtol=rtol, equal_nan=True)
        worst = np.nanmax(np.abs(a - b)) if a.shape == b.shape and a.size else f"{a.shape} {b.shape}"
        self.ok(what, good, f"by {worst}")


def read_pyuvdata(path, strict):
    """All that pyuvdata reads, as stored: no phasing, and no repair of the baselines' direction."""
    uv = UVData()
    read = uv.read_uvh5 if pathlib.Path(path).suffix == ".uvh5" else uv.read_uvfits
    read(path, run_check=False, fix_old_proj=False)
    if strict:
        uv.check(check_extra=True, run_check_acceptability=True, allow_flip_conj=False,
                 check_freq_spacing=True)
    return uv


def freq_tol_hz(uv):
    """CH WIDTH of the FQ table is a 32-bit float, and pyuvdata takes it where there is a table."""
    return 1e-3 + 6e-8 * np.max(np.abs(uv.channel_width)) * uv.Nfreqs


def compare(check, ours, uv, uvw_tol_m, time_tol_s):
    """Our arrays against pyuvdata's."""
    obs = ours.obs
    check.ok("number of rows", ours.n_row == uv.Nblts == obs["n_row"])
    numbers = np.array([antenna["number"] for antenna in obs["antennas"]])
    check.ok("ant1", np.array_equal(numbers[ours.ant1], uv.ant_1_array))
    check.ok("ant2", np.array_equal(numbers[ours.ant2], uv.ant_2_array))
    check.close("uvw [m]", ours.uvw_m, -uv.uvw_array, uvw_tol_m, 1e-14)
    seconds = ((ours.time_mjd + 2400000.5) - uv.time_array) * 86400
    check.close("time [s]", seconds, 0 * seconds, time_tol_s)
    if not np.all(np.isnan(ours.interval_s)):
        check.close("interval [s]", ours.interval_s, uv.integration_time, 0, 1e-6)
    codes = [CORR_CODES[corr] for corr in obs["corrs"]]
    order = [list(uv.polarization_array).index(code) for code in codes]
    check.close("frequency [Hz]", obs["freq_setups"][0]["freq_hz_f"], uv.freq_array, freq_tol_hz(uv))
    flags = uv.flag_array[..., order].astype(bool)
    data = np.conj(uv.data_array[..., order]).astype("c8")
    odd = ~np.isfinite(data)
    check.ok("flags", np.array_equal(ours.flag, flags | odd))
    check.ok("data", np.array_equal(ours.vis[~odd], data[~odd]))
    good = ~ours.flag
    check.ok("weights", np.array_equal(ours.weight[good], uv.nsample_array[..., order][good]))
    check.ok("weights of flagged", np.all(ours.weight[ours.flag] == 0))
    centre = [c.to_value("m") for c in uv.telescope.location.geocentric]
    absolute = uv.telescope.antenna_positions + np.array(centre)
    by_number = {n: absolute[i] for i, n in enumerate(uv.telescope.antenna_numbers)}
    theirs = np.array([by_number[n] for n in numbers])
    check.close("antennas [m]", [a["itrf_m"] for a in obs["antennas"]], theirs, 1e-6)
    for field in obs["fields"]:
        entry = list(uv.phase_center_catalog.values())[0] if len(obs["fields"]) == 1 else next(
            e for e in uv.phase_center_catalog.values() if e["cat_name"] == field["name"])
        check.close("RA, Dec [rad]", [field["ra_rad"], field["dec_rad"]],
                    [entry["cat_lon"], entry["cat_lat"]], 1e-12)
        frame = field["frame"] if isinstance(field["frame"], str) else list(field["frame"])[0]
        # pyuvdata does not look at EQUINOX and so takes a header with nothing else for ICRS.
        known = entry["cat_frame"] != "icrs" or entry.get("cat_epoch") is not None
        check.ok("frame", not known or frame.lower() == entry["cat_frame"], frame)


def compare_pyuvdata(check, a, b):
    """pyuvdata's view of the original against its view of what we wrote from it."""
    check.ok("n", (a.Nblts, a.Nfreqs, a.Npols, a.Nspws) == (b.Nblts, b.Nfreqs, b.Npols, b.Nspws))
    check.close("uvw [m]", a.uvw_array, b.uvw_array, 1e-9, 1e-14)
    check.close("time [s]", (a.time_array - b.time_array) * 86400, 0 * a.time_array, 1e-4)
    check.close("freq", a.freq_array, b.freq_array, freq_tol_hz(a))
    check.ok("flags", np.array_equal(a.flag_array | ~np.isfinite(a.data_array), b.flag_array))
    good = ~b.flag_array
    check.ok("nsample", np.array_equal(a.nsample_array[good], b.nsample_array[good]))
    check.ok("data", np.array_equal(a.data_array[np.isfinite(a.data_array)],
                                    b.data_array[np.isfinite(a.data_array)]))
    check.ok("channel width", np.allclose(a.channel_width, b.channel_width))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="+", type=pathlib.Path)
    parser.add_argument("--target", type=pathlib.Path, default=ROOT / "target" / "release")
    arguments = parser.parse_args()
    tools = arguments.target / "examples"
    bad = 0
    for path in arguments.files:
        check = Check(path.name)
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            uv = read_pyuvdata(path, strict=0)
            compare(check, Ours(tools, path, folder), uv, 1e-9, 1e-4)

            written = folder / "ours.uvfits"
            subprocess.run([tools / "rewrite_vis", path, written], check=True)
            verified = subprocess.run(["fitsverify", "-e", "-q", written], capture_output=True, text=True)
            check.ok("fitsverify", verified.returncode == 0, verified.stdout)
            check.name = f"{path.name} written by us"
            back = read_pyuvdata(written, strict=1)
            compare(check, Ours(tools, written, folder), back, 1e-9, 1e-4)
            compare_pyuvdata(check, uv, back)

            check.name = f"{path.name} written by pyuvdata"
            theirs = folder / "theirs.uvfits"
            try:
                uv.write_uvfits(theirs, run_check=False, fix_autos=False)
            except Exception as error:  # pyuvdata cannot write back every file that it reads
                print(f"  {path.name}: pyuvdata does not write it back: {error}")
            else:
                compare(check, Ours(tools, theirs, folder), read_pyuvdata(theirs, strict=0), 1e-9, 1e-4)
        print(f"{'ok ' if check.bad == 0 else 'BAD'} {path.name}: {uv.Nblts} rows")
        bad += check.bad
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
