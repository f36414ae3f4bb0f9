#!/usr/bin/env python3
"""Make fixtures/good/*.uvh5: tiny files written by pyuvdata (3.2 or later), always the same.

    make_good_uvh5.py [FOLDER]

Some are then changed with h5py into what older or other writers make. Each file has a JSON beside
it with what a reader must find in it, as `make_good_uvfits.py` has it; uvh5_NAME.uvh5 holds the
observation of pyuvdata_NAME.uvfits where there is one.
"""

import json
import pathlib
import sys

import h5py
import numpy as np

from make_good_uvfits import ROOT, expectation, observe

LINEAR = [-5, -6]


def plain(seed, n_spw=1, pols=LINEAR, n_source=1):
    """The observation that variants start from."""
    return observe([0, 1, 5, 7], 3, n_spw, 2, pols, n_source, seed)


def whole_numbers(uv):
    """The same with visibilities that integers can hold."""
    uv.data_array = np.round(1000 * uv.data_array)
    return uv


def baseline_major(uv):
    uv.reorder_blts(order="baseline", minor_order="time")
    return uv


def any_order(uv):
    """Rows in no order, some of them missing."""
    order = np.random.default_rng(9).permutation(uv.Nblts)
    uv.reorder_blts(order=order)
    uv.select(blt_inds=np.arange(5, uv.Nblts))
    return uv


def unequal_windows():
    """Three spectral windows, of 1, 2 and 3 channels, in an order of their own; the last falls."""
    uv = observe([0, 1, 5], 2, 1, 6, LINEAR, 1, 15)
    uv.spw_array = np.array([7, 3, 4])
    uv.Nspws = 3
    uv.flex_spw_id_array = np.array([7, 3, 3, 4, 4, 4])
    uv.freq_array = np.array([1.6e9, 1.4e9, 1.4005e9, 1.503e9, 1.502e9, 1.501e9])
    uv.channel_width = np.array([1e6, 5e5, 5e5, 1e6, 1e6, 1e6])
    return uv


def to_old(path):
    """Phase centre and shapes as files before version 1.0 have them."""
    with h5py.File(path, "r+") as f:
        h = f["Header"]
        entry = h["phase_center_catalog/0"]
        h["phase_type"] = np.bytes_("phased")
        h["phase_center_ra"] = entry["cat_lon"][()]
        h["phase_center_dec"] = entry["cat_lat"][()]
        h["phase_center_frame"] = entry["cat_frame"][()]
        h["phase_center_epoch"] = 2000.0
        h["object_name"] = entry["cat_name"][()]
        for name in ("phase_center_catalog", "phase_center_id_array", "Nphase", "flex_spw_id_array",
                     "phase_center_app_ra", "phase_center_app_dec", "phase_center_frame_pa",
                     "version", "lst_array"):
            del h[name]
        replace(h, "freq_array", h["freq_array"][()][np.newaxis])
        replace(h, "channel_width", h["channel_width"][0])
        replace(h, "Nbls", h["Nblts"][()])
        for name in ("visdata", "flags", "nsamples"):
            old = f["Data"][name]
            array, compression = old[()], old.compression
            del f["Data"][name]
            f["Data"].create_dataset(name, data=array[:, np.newaxis], chunks=True,
                                     compression=compression)


def to_other_types(path):
    """Texts of variable length, big-endian numbers, flags as bytes, members without a value."""
    with h5py.File(path, "r+") as f:
        h = f["Header"]
        texts = [n for n, d in h.items() if isinstance(d, h5py.Dataset) and d.dtype.kind == "S"]
        for name in texts:
            value = h[name][()]
            if h[name].shape:
                text = [v.decode() for v in value]
            else:
                text = value.decode()
            del h[name]
            h.create_dataset(name, data=text, dtype=h5py.string_dtype())
        for name in ("ant_1_array", "antenna_numbers", "polarization_array"):
            replace(h, name, h[name][()].astype(">i2"))
        replace(h, "uvw_array", h["uvw_array"][()].astype(">f8"))
        h["antenna_diameters_"] = h["antenna_diameters"][()]
        del h["antenna_diameters_"], h["antenna_diameters"]
        h["antenna_diameters"] = h5py.Empty("f")
        flags = f["Data/flags"][()]
        replace(f["Data"], "flags", flags.astype("u1"))
        vis = f["Data/visdata"][()]
        big = np.zeros(vis.shape, pair(">i8"))
        big["r"], big["i"] = vis.real, vis.imag
        replace(f["Data"], "visdata", big)


def replace(group, name, value):
    del group[name]
    group[name] = value


def pair(kind):
    return np.dtype([("r", kind), ("i", kind)])


# Name, observation, what write_uvh5 is told, what is changed afterwards.
CASES = [
    ("small", lambda: observe([1, 2, 3, 4], 3, 1, 2, LINEAR, 1, 1), {}, None),
    ("ifs_sources", lambda: observe([2, 5, 9], 4, 3, 2, [-1, -2, -3, -4], 2, 2), {}, None),
    ("large_numbers", lambda: observe([1, 255, 256, 600, 2049], 2, 1, 1, [-5, -6, -7, -8], 1, 3), {}, None),
    ("stokes_i", lambda: observe([1, 2, 3], 4, 1, 3, [1], 1, 4), {}, None),
    ("old_phase", lambda: plain(10), {}, to_old),
    ("int32", lambda: whole_numbers(plain(11)), {"data_write_dtype": pair("<i4")}, None),
    ("int16_big_endian", lambda: whole_numbers(plain(12)), {"data_write_dtype": pair(">i2")}, None),
    ("float64", lambda: plain(13), {"data_write_dtype": "c16"}, None),
    ("float16", lambda: whole_numbers(plain(14, pols=[-5])), {"data_write_dtype": pair("<f2")}, None),
    ("unequal_windows", unequal_windows, {}, None),
    ("gzip", lambda: plain(16, n_source=3), {"data_compression": "gzip", "flags_compression": "gzip",
                                             "nsample_compression": "gzip"}, None),
    ("lzf_cut_chunks", lambda: plain(17, n_spw=2, pols=[-5, -6, -7, -8]),
     {"data_compression": "lzf", "chunks": (7, 3, 2)}, None),
    ("contiguous", lambda: plain(18), {"chunks": None, "flags_compression": None,
                                       "nsample_compression": None}, None),
    ("baseline_major", lambda: baseline_major(plain(19)), {"chunks": (4, 2, 1)}, None),
    ("any_order", lambda: any_order(plain(20, n_source=2)), {}, None),
    ("other_types", lambda: whole_numbers(plain(21)), {}, to_other_types),
]


def main():
    folder = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "fixtures" / "good"
    folder.mkdir(parents=True, exist_ok=True)
    for name, make, options, change in CASES:
        path = folder / f"uvh5_{name}.uvh5"
        uv = make()
        uv.history = "made by make_good_uvh5.py"
        uv.write_uvh5(path, clobber=True, run_check=False, **options)
        if change:
            change(path)
            # h5py leaves holes where things were; a copy has none.
            whole = path.with_suffix(".new")
            with h5py.File(path) as old, h5py.File(whole, "w") as new:
                for group in old:
                    old.copy(group, new)
            whole.replace(path)
        path.with_suffix(".json").write_text(json.dumps(expectation(path), indent=1) + "\n")
        print(path, path.stat().st_size)


if __name__ == "__main__":
    main()
