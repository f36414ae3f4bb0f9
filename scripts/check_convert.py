#!/usr/bin/env python3
"""Compare `vis2cat convert` with selection and averages with pyuvdata's select, frequency_average and
downsample_in_time.

    check_convert.py --target target/release FILE...

Each FILE must have at least 4 channels, a number of them that 4 divides, and 8 times of one length. A
copy with weights of 2 and random flags is converted; what pyuvdata makes of the same copy must be equal
to the precision of the numbers: visibilities, flags, weights (pyuvdata takes their mean where we take
their sum, so ours are divided by what was averaged), times, frequencies, and (u, v, w): pyuvdata has
them at mid-time and we in the mean with the weights of the samples, so means are formed here.
"""

import argparse
import pathlib
import subprocess
import sys
import tempfile
import warnings

import numpy as np

warnings.simplefilter("ignore")
from pyuvdata import UVData  # noqa: E402


def read(path):
    data = UVData()
    data.read(path)
    return data


def flagged_copy(source, target):
    data = read(source)
    data.nsample_array[:] = 2
    data.flag_array = np.random.default_rng(1).random(data.flag_array.shape) < 0.2
    # All of a time of a baseline, and all that becomes one channel of another.
    data.flag_array[3] = True
    data.flag_array[7, :4] = True
    data.write_uvh5(target, clobber=True)
    return data


def ordered(data):
    """Baselines may run either way and rows may come in any order: ours as pyuvdata has them."""
    data.reorder_blts(order="time", conj_convention="ant1<ant2")
    return data


def weighted_uvw(data, averaged, n_time):
    """The mean of (u, v, w) over steps of that many times for the rows of `averaged`."""
    times = np.unique(data.time_array)
    row = {key: r for r, key in enumerate(zip(data.baseline_array, np.searchsorted(times, data.time_array)))}
    weight = (data.nsample_array * ~data.flag_array).sum(axis=(1, 2))
    means = []
    for baseline, time in zip(averaged.baseline_array, averaged.time_array):
        first = (np.searchsorted(times, time) - 1) // n_time * n_time
        rows = [row[baseline, t] for t in range(first, min(first + n_time, len(times))) if (baseline, t) in row]
        some = weight[rows] if weight[rows].any() else np.ones(len(rows))
        means.append(some @ data.uvw_array[rows] / some.sum())
    return np.array(means)


def same(what, ours, theirs, factor=1.0, uvw_m=None):
    ours, theirs = ordered(ours), ordered(theirs)
    close = lambda a, b, tol: np.testing.assert_allclose(a, b, rtol=0, atol=tol, err_msg=what)
    assert ours.data_array.shape == theirs.data_array.shape, (what, ours.data_array.shape, theirs.data_array.shape)
    np.testing.assert_array_equal(ours.baseline_array, theirs.baseline_array, what)
    np.testing.assert_array_equal(ours.flag_array, theirs.flag_array, what)
    good = ~ours.flag_array
    scale = np.abs(theirs.data_array[good]).max()
    close(ours.data_array[good], theirs.data_array[good], 3e-6 * scale)
    np.testing.assert_allclose(ours.nsample_array[good] / factor, theirs.nsample_array[good],
                               rtol=1e-5, err_msg=what)
    close(ours.time_array, theirs.time_array, 1e-9)
    close(ours.integration_time, theirs.integration_time, 1e-5)
    close(ours.freq_array, theirs.freq_array, 1e-3)
    close(ours.channel_width, theirs.channel_width, 1e-3)
    close(ours.uvw_array, theirs.uvw_array if uvw_m is None else uvw_m, 1e-6)
    print(f"  {what}: {ours.Nblts} rows, {ours.Nfreqs} channels, {ours.Npols} correlations")


def check(binary, path, folder):
    print(path.name)
    source = folder / "source.uvh5"
    data = flagged_copy(path, source)
    names = [str(name) for name in data.telescope.antenna_names]
    number = dict(zip(names, data.telescope.antenna_numbers))
    used = set(data.ant_1_array) | set(data.ant_2_array)
    one, two, three = [name for name in names if number[name] in used][:3]
    times = np.unique(data.time_array)
    first, last = times[2] - 2400000.5, times[5] - 2400000.5

    def convert(*options):
        out = folder / "out.uvh5"
        command = [binary, "convert", source, out, "--overwrite", "--quiet", *options]
        subprocess.run([str(part) for part in command], check=True)
        return read(out)

    theirs = read(source)
    theirs.select(times=times[2:6])
    edge = 1e-6
    same("times", convert("--times", f"{first - edge}..{last + edge}"), theirs)

    theirs = read(source)
    theirs.select(freq_chans=[1, 2, 3])
    same("channels", convert("--channels", "1:3"), theirs)

    theirs = read(source)
    pairs = [(number[one], number[two])] + [(number[three], int(n)) for n in used]
    has = set(data.get_antpairs())
    pairs = [p for p in pairs if p in has or p[::-1] in has]
    theirs.select(bls=pairs)
    same("baselines", convert("--baselines", f"{one}&{two},{three}"), theirs)

    theirs = read(source)
    theirs.frequency_average(4)
    ours = convert("--average-channels", "4")
    # pyuvdata has the mean weight of the channels, flagged ones included or not by version: ours is
    # the sum over those that are good.
    good = ordered(read(source))
    count = (~good.flag_array).reshape(good.Nblts, -1, 4, good.Npols).sum(axis=2)
    theirs = ordered(theirs)
    theirs.nsample_array = 2.0 * count
    same("channels averaged", ours, theirs)

    step = 4 * float(data.integration_time[0])
    theirs = read(source)
    theirs.downsample_in_time(min_int_time=step * 0.999, keep_ragged=True)
    ours = ordered(convert("--average-time", f"{step}s"))
    means = weighted_uvw(ordered(read(source)), ours, 4)
    same("times averaged", ours, theirs, factor=4.0, uvw_m=means)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--target", type=pathlib.Path, default=pathlib.Path("target/release"))
    parser.add_argument("files", nargs="+", type=pathlib.Path)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for path in arguments.files:
            check(arguments.target / "vis2cat", path, pathlib.Path(folder))


if __name__ == "__main__":
    sys.exit(main())
