#!/usr/bin/env python3
"""Make fixtures/bad/*.uvh5: small files that are wrong in one way each.

    make_bad_uvh5.py [FOLDER]

Beside each stands a .txt with the message that the reader must give, without the path in front.
Needs h5py. The file that all cases start from is right in every way.
"""

import pathlib
import sys
import tempfile

import h5py
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
N_ROW, N_CHAN, N_POL = 6, 3, 2


def good(f):
    """A right file."""
    h = f.create_group("Header")
    scalars = {"Nblts": N_ROW, "Nfreqs": N_CHAN, "Npols": N_POL, "Nspws": 1, "Ntimes": 2, "Nbls": 3,
               "Nants_data": 3, "Nants_telescope": 3, "Nphase": 1, "latitude": -30.7,
               "longitude": 21.4, "altitude": 1050.0}
    for name, value in scalars.items():
        h[name] = value
    for name in ("telescope_name", "instrument", "history"):
        h[name] = np.bytes_("BAD")
    h["version"], h["vis_units"], h["telescope_frame"] = map(np.bytes_, ("1.2", "Jy", "itrs"))
    h["antenna_numbers"] = np.array([1, 2, 3])
    h["antenna_names"] = np.array([b"A1", b"A2", b"A3"])
    h["antenna_positions"] = 100.0 * np.arange(9).reshape(3, 3)
    h["ant_1_array"], h["ant_2_array"] = np.array([1, 1, 2] * 2), np.array([2, 3, 3] * 2)
    h["uvw_array"] = np.arange(3.0 * N_ROW).reshape(N_ROW, 3)
    h["time_array"] = 2460000.5 + np.repeat([0.0, 1e-4], 3)
    h["integration_time"] = np.full(N_ROW, 8.0)
    h["freq_array"] = 1.4e9 + 1e6 * np.arange(N_CHAN)
    h["channel_width"] = np.full(N_CHAN, 1e6)
    h["spw_array"], h["flex_spw_id_array"] = np.array([1]), np.ones(N_CHAN, int)
    h["polarization_array"] = np.array([-5, -6])
    h["phase_center_id_array"] = np.zeros(N_ROW, int)
    entry = h.create_group("phase_center_catalog/0")
    entry["cat_name"], entry["cat_type"] = np.bytes_("SRC"), np.bytes_("sidereal")
    entry["cat_frame"] = np.bytes_("icrs")
    entry["cat_lon"], entry["cat_lat"] = 0.3, -0.6
    shape = (N_ROW, N_CHAN, N_POL)
    data = f.create_group("Data")
    data.create_dataset("visdata", data=np.ones(shape, "c8"), chunks=(3, 3, 2))
    data.create_dataset("flags", data=np.zeros(shape, bool), chunks=(6, 3, 2), compression="lzf")
    data.create_dataset("nsamples", data=np.ones(shape, "f4"), chunks=(6, 3, 2), compression="gzip")


def put(**values):
    """A case with other members of the header; None takes one away."""
    def change(f):
        for name, value in values.items():
            if name in f["Header"]:
                del f["Header"][name]
            if value is not None:
                f["Header"][name] = value
    return change


def data(name, make=None, **options):
    """A case with another dataset of visibilities."""
    def change(f):
        del f["Data"][name]
        if make:
            f["Data"].create_dataset(name, **make(), **options)
    return change


def entry(**values):
    """A case with other members of the one phase centre."""
    def change(f):
        put(**{f"phase_center_catalog/0/{name}": value for name, value in values.items()})(f)
    return change


def old(kind):
    """A case with the phase centre of old files."""
    def change(f):
        put(phase_center_catalog=None, phase_center_id_array=None, phase_type=np.bytes_(kind))(f)
    return change


def elsewhere(f):
    del f["Header/uvw_array"]
    f["Header/uvw_array"] = h5py.ExternalLink("other.uvh5", "/Header/uvw_array")


def outside(f):
    del f["Header/time_array"]
    f["Header"].create_dataset("time_array", (N_ROW,), "f8", external=[("/dev/zero", 0, 8 * N_ROW)])


def virtual(f):
    del f["Data/flags"]
    plist = quiet_plist()
    space = h5py.h5s.create_simple((N_ROW, N_CHAN, N_POL))
    plist.set_virtual(space, b"other.uvh5", b"Data/flags", space)
    h5py.h5d.create(f["Data"].id, b"flags", h5py.h5t.py_create(np.dtype(bool), logical=True), space, plist)


def quiet_plist():
    """How to create a dataset that does not say when it was."""
    plist = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    plist.set_obj_track_times(False)
    return plist


def unknown_filter(number):
    """A case whose visibilities say that they went through a filter."""
    def change(f):
        del f["Data/visdata"]
        plist = quiet_plist()
        plist.set_chunk((3, 3, 2))
        # A flag that lets files with it be made where the filter is not there.
        plist.set_filter(number, h5py.h5z.FLAG_OPTIONAL, (0, 2))
        space = h5py.h5s.create_simple((N_ROW, N_CHAN, N_POL))
        kind = h5py.h5t.py_create(np.dtype("c8"), logical=True)
        h5py.h5d.create(f["Data"].id, b"visdata", kind, space, plist)
    return change


def shape(*lens, dtype="c8", **more):
    return lambda: {"data": np.zeros(lens, dtype), **more}


def sparse(*lens, dtype="c8", chunks=None):
    """A dataset that takes no place in the file: nothing was written to it."""
    return lambda: {"shape": lens, "dtype": dtype, "chunks": chunks}


HUGE = 2**40
REAL_ROW = np.arange(3.0 * N_ROW).reshape(N_ROW, 3)
CASES = {
    # Not UVH5.
    "no_header": (lambda f: f.move("Header", "Head"),
        "Header: is missing: this HDF5 file is no UVH5 file"),
    "no_data": (lambda f: f.move("Data", "Date"),
        "Data: is missing: this HDF5 file is no UVH5 file"),
    # Members that are missing or of another kind.
    "no_visdata": (data("visdata"),
        "Data/visdata: is missing; the file may not have been finished"),
    "no_flags": (data("flags"),
        "Data/flags: is missing; the file may not have been finished"),
    "no_nblts": (put(Nblts=None),
        "Header/Nblts: is missing; the file may not have been finished"),
    "no_uvw": (put(uvw_array=None),
        "Header/uvw_array: is missing; the file may not have been finished"),
    "null_uvw": (put(uvw_array=h5py.Empty("f8")),
        "Header/uvw_array: is missing; the file may not have been finished"),
    "text_uvw": (put(uvw_array=np.full((N_ROW, 3), b"1.0")),
        "Header/uvw_array: must hold numbers, holds text"),
    "text_count": (put(Nfreqs=np.bytes_("3")),
        "Header/Nfreqs: must hold whole numbers, holds text"),
    "fraction_count": (put(Nfreqs=3.0),
        "Header/Nfreqs: must hold whole numbers, holds real numbers"),
    "list_count": (put(Nfreqs=np.array([3, 3])),
        "Header/Nfreqs: has shape [2], must be one value"),
    "number_name": (put(telescope_name=5),
        "Header/telescope_name: must hold text, holds whole numbers"),
    "real_vis": (data("visdata", shape(N_ROW, N_CHAN, N_POL, dtype="f4")),
        "Data/visdata: must hold compounds of two numbers r and i, holds real numbers"),
    "other_compound": (data("visdata", shape(N_ROW, N_CHAN, N_POL, dtype=[("re", "f4"), ("im", "f4")])),
        "Data/visdata: must hold compounds of two numbers r and i, holds type compound (2 fields)"),
    "real_flags": (data("flags", shape(N_ROW, N_CHAN, N_POL, dtype="f4")),
        "Data/flags: must hold booleans, holds real numbers"),
    # Sizes that lie.
    "rank_two": (data("visdata", shape(N_ROW, N_CHAN)),
        "Data/visdata: has shape [6, 3], must be (Nblts, Nfreqs, Npols)"),
    "two_windows_axis": (data("visdata", shape(N_ROW, 2, N_CHAN, N_POL)),
        "Data/visdata: has an axis of 2 spectral windows, which only the first files had; read and "
        "write it with pyuvdata"),
    "nblts_huge": (put(Nblts=HUGE),
        "Header/Nblts: is 1099511627776, but Data/visdata has 6"),
    "nblts_negative": (put(Nblts=-6),
        "Header/Nblts: is -6, must not be negative"),
    "nblts_zero": (lambda f: (put(Nblts=0)(f), data("visdata", shape(0, N_CHAN, N_POL))(f)),
        "Header/Nblts: is 0: the file holds no visibilities"),
    "flags_short": (data("flags", shape(N_ROW - 1, N_CHAN, N_POL, dtype=bool)),
        "Data/flags: has shape [5, 3, 2], must have [6, 3, 2]"),
    "uvw_short": (put(uvw_array=REAL_ROW[:5]),
        "Header/uvw_array: has shape [5, 3], must have [6, 3]"),
    "uvw_pairs": (put(uvw_array=REAL_ROW[:, :2]),
        "Header/uvw_array: has shape [6, 2], must have [6, 3]"),
    "antennas_announced": (put(Nants_telescope=10**9),
        "Header/antenna_numbers: has shape [3], must have [1000000000]"),
    "rows_never_written": (lambda f: (
        put(Nblts=HUGE)(f), data("visdata", sparse(HUGE, N_CHAN, N_POL, chunks=(1000, 3, 2)))(f),
        data("flags", sparse(HUGE, N_CHAN, N_POL, dtype=bool, chunks=(1000, 3, 2)))(f)),
        "Data/flags: was never written: the file is unfinished"),
    "channels_never_written": (lambda f: (
        put(Nfreqs=HUGE, freq_array=None)(f),
        data("visdata", sparse(N_ROW, HUGE, N_POL, chunks=(1, 1000, 2)))(f),
        f["Header"].create_dataset("freq_array", (HUGE,), "f8", chunks=(1000,))),
        "Header/freq_array: its shape [1099511627776] announces 8796093022208 bytes, the file has 0 "
        "for it: it is truncated, unfinished or the header is wrong"),
    "header_bomb": (lambda f: (
        put(Nants_telescope=2**23, antenna_numbers=None, antenna_names=None)(f),
        f["Header"].create_dataset("antenna_numbers", data=np.zeros(2**23, "i1"), compression="gzip",
                                   chunks=(2**23,)),
        f["Header"].create_dataset("antenna_names", data=np.full(2**23, b"a"), compression="gzip",
                                   chunks=(2**23,))),
        "Header/antenna_names: its shape [8388608] is more than a header can have"),
    "shape_overflows": (data("visdata", sparse(2**33, 2**33, 2, chunks=(1, 1, 2))),
        "Data/visdata: its shape [8589934592, 8589934592, 2] is of more bytes than any file has"),
    "chunk_huge": (data("visdata", lambda: {"shape": (N_ROW, N_CHAN, N_POL), "dtype": "c8",
                                            "maxshape": (None, None, None),
                                            "chunks": (2**13, 2**12, 2), "compression": "lzf"}),
        "Data/visdata: its chunks are of 536870912 bytes each and have to be unpacked whole; write "
        "smaller ones, with h5repack"),
    "times_unfinished": (lambda f: (put(time_array=None)(f), f["Header"].create_dataset(
        "time_array", (N_ROW,), "f8", chunks=(3,)), f["Header/time_array"].__setitem__(0, 1.0)),
        "Header/time_array: 1 of 2 chunks were written: the file is unfinished"),
    # Out of the file.
    "external_link": (elsewhere,
        "Header/uvw_array: is a link to another file, which is not followed; copy the data into "
        "this file, with h5repack or h5copy"),
    "external_storage": (outside,
        "Header/time_array: the data stand in another file, which is not followed; copy them into "
        "this file, with h5repack"),
    "virtual": (virtual,
        "Data/flags: the data stand in another file, which is not followed; copy them into this "
        "file, with h5repack"),
    # Filters.
    "bitshuffle": (unknown_filter(32008),
        "Data/visdata: is compressed with bitshuffle (filter 32008), which is not built in; let "
        "HDF5_PLUGIN_PATH name a folder with its plugin (as in the Python package hdf5plugin) or "
        "rewrite the file with h5repack -f GZIP=1"),
    "filter_unknown": (unknown_filter(31999),
        "Data/visdata: is compressed with filter 31999, which is not built in; let "
        "HDF5_PLUGIN_PATH name a folder with its plugin (as in the Python package hdf5plugin) or "
        "rewrite the file with h5repack -f GZIP=1"),
    # Antennas.
    "antenna_twice": (put(antenna_numbers=np.array([1, 2, 1])),
        "Header/antenna_numbers: has antenna 1 twice"),
    "antenna_negative": (put(antenna_numbers=np.array([1, 2, -3])),
        "Header/antenna_numbers: -3 is no antenna number"),
    "antenna_nowhere": (put(antenna_positions=np.full((3, 3), np.nan)),
        "Header/antenna_positions: antenna 1: is not finite"),
    "antenna_unknown": (put(ant_2_array=np.array([2, 3, 3, 2, 9, 3])),
        "Header/ant_2_array: row 5 of 6: antenna 9 is not in antenna_numbers"),
    "on_the_moon": (put(telescope_frame=np.bytes_("mcmf")),
        "Header/telescope_frame: is 'mcmf': only positions on the Earth (itrs) are read"),
    "latitude": (put(latitude=120.0),
        "Header/latitude: 120 deg"),
    # Channels and correlations.
    "freq_nan": (put(freq_array=np.array([1e9, np.nan, 1e9])),
        "Header/freq_array: channel 2: NaN Hz is no frequency"),
    "width_nan": (put(channel_width=np.full(N_CHAN, np.nan)),
        "Header/channel_width: NaN Hz is no width"),
    "window_unknown": (put(flex_spw_id_array=np.array([1, 1, 2])),
        "Header/flex_spw_id_array: spectral window 2 is not in spw_array"),
    "windows_unsaid": (put(spw_array=np.array([1, 2]), flex_spw_id_array=None),
        "Header/flex_spw_id_array: is missing, but there are 2 spectral windows"),
    "window_per_hand": (put(flex_spw_polarization_array=np.array([-5])),
        "Header/flex_spw_polarization_array: every spectral window has a polarization of its own, "
        "which is not read; convert with pyuvdata's remove_flex_pol"),
    "polarization_unknown": (put(polarization_array=np.array([-5, -9])),
        "Header/polarization_array: -9 is no known correlation"),
    "polarization_twice": (put(polarization_array=np.array([-5, -5])),
        "Header/polarization_array: has Xx twice"),
    # Phase centres.
    "ephemeris": (entry(cat_type=np.bytes_("ephem")),
        "Header/phase_center_catalog: 'SRC' is of type 'ephem': only sidereal phase centres are "
        "read; phase the data to one, with pyuvdata's UVData.phase"),
    "frame_unknown": (entry(cat_frame=np.bytes_("altaz")),
        "Header/phase_center_catalog: 'SRC': is in frame 'altaz'; icrs, fk5 and fk4 are read: phase "
        "the data to one of these, with pyuvdata's UVData.phase"),
    "beyond_the_pole": (entry(cat_lat=2.0),
        "Header/phase_center_catalog/0/cat_lat: 2 rad is no such angle"),
    "phase_centre_unknown": (put(phase_center_id_array=np.array([0, 0, 0, 7, 0, 0])),
        "Header/phase_center_id_array: row 4 of 6: 7 is not in phase_center_catalog"),
    "phase_centre_text": (put(phase_center_catalog=np.bytes_("{}")),
        "Header/phase_center_catalog: is a text, as files of version 1.0 have it, which is not "
        "read; read and write the file with pyuvdata"),
    "catalog_of_numbers": (lambda f: f.move("Header/phase_center_catalog/0", "Header/phase_center_catalog/a"),
        "Header/phase_center_catalog/a: is no number of a phase centre"),
    "group_for_dataset": (lambda f: (put(uvw_array=None)(f), f.create_group("Header/uvw_array")),
        "Header/uvw_array: must be a dataset, is a group"),
    "dataset_for_group": (lambda f: (f.__delitem__("Data"), f.__setitem__("Data", 1.0)),
        "Data: must be a group, is a dataset"),
    # Rows.
    "uvw_nan": (put(uvw_array=np.where(REAL_ROW == 4, np.nan, REAL_ROW)),
        "Header/uvw_array: row 2 of 6: NaN is not finite"),
    "time_infinite": (put(time_array=np.array([2460000.5] * 5 + [np.inf])),
        "Header/time_array: row 6 of 6: inf is not finite"),
}


def make(change, path):
    # Newer layouts are more compact.
    with h5py.File(path, "w", libver=("v110", "v110")) as f:
        good(f)
        change(f)


# Bytes of the structures that index the names of a group, with the right checksum: signature, length, and what
# stands where. libhdf5 believes them.
INDEX_CASES = {
    "names_record_empty": (b"BTHD", 38, 10, bytes(2), "Header: its index of names is damaged"),
    "names_node_empty": (b"BTHD", 38, 6, bytes(4), "Header: its index of names is damaged"),
    "names_heap_narrow": (b"FRHP", 146, 110, b"\x01\x00", "Header: its heap of links is damaged"),
    "names_heap_tall": (b"FRHP", 146, 140, b"\xff\xff", "Header: its heap of links is damaged"),
}


def lookup3(data):
    """Jenkins' checksum of 32 bits, as HDF5 has it of its structures."""
    def rotate(x, k):
        return (x << k | x >> (32 - k)) & 0xFFFFFFFF

    state = [(0xDEADBEEF + len(data)) & 0xFFFFFFFF] * 3
    for at in range(0, len(data), 12):
        block = data[at:at + 12].ljust(12, b"\0")
        a, b, c = (x + int.from_bytes(block[4 * i:4 * i + 4], "little") & 0xFFFFFFFF for i, x in enumerate(state))
        if at + 12 >= len(data):
            break
        for k in (4, 6, 8, 16, 19, 4):
            a = (a - c & 0xFFFFFFFF) ^ rotate(c, k)
            a, b, c = b, c + b & 0xFFFFFFFF, a
        state = [a, b, c]
    for k in (14, 11, 25, 16, 4, 14, 24):
        c = (c ^ b) - rotate(b, k) & 0xFFFFFFFF
        a, b, c = b, c, a
    return b


def spoilt(raw, signature, length, at, new):
    """A file with other bytes in one of its structures, whose checksum is right."""
    first = raw.index(signature)
    part = bytearray(raw[first:first + length])
    assert lookup3(part[:-4]).to_bytes(4, "little") == part[-4:]
    part[at:at + len(new)] = new
    part[-4:] = lookup3(part[:-4]).to_bytes(4, "little")
    return raw[:first] + bytes(part) + raw[first + length:]


def endless(f):
    """A text of any length, in a collection of such."""
    del f["Header/telescope_name"]
    f["Header/telescope_name"] = "BAD"


def without_end(raw):
    """A file whose collection of texts has a part that takes nothing."""
    at = raw.index(b"GCOL") + 16
    while raw[at:at + 2] != bytes(2):
        at += 16 + -(-int.from_bytes(raw[at + 8:at + 16], "little") // 8) * 8
    return raw[:at + 8] + bytes(8) + raw[at + 16:]


def main():
    folder = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "fixtures" / "bad"
    folder.mkdir(parents=True, exist_ok=True)
    for name, (change, message) in CASES.items():
        make(change, folder / f"{name}.uvh5")
        (folder / f"{name}.uvh5.txt").write_text(message + "\n")
    with tempfile.TemporaryDirectory() as temporary:
        whole = pathlib.Path(temporary) / "good.uvh5"
        make(lambda f: None, whole)
        raw = whole.read_bytes()
        make(endless, whole)
        (folder / "texts_endless.uvh5").write_bytes(without_end(whole.read_bytes()))
        (folder / "texts_endless.uvh5.txt").write_text(
            "Header/telescope_name: its collection of texts is damaged; the file is damaged or truncated: copy it again\n")
    for name, n_byte, why in (
        ("cut_in_superblock", 40, "incorrect metadata checksum after all read attempts"),
        ("cut_in_half", len(raw) // 2, f"truncated file: eof = {len(raw) // 2}, {{}}"),
        ("cut_at_end", len(raw) - 1, f"truncated file: eof = {len(raw) - 1}, {{}}"),
    ):
        why = why.format(f"sblock->base_addr = 0, stored_eof = {len(raw)}")
        message = (f"file: cannot be read (H5Fopen(): unable to synchronously open file: {why}); the "
                   "file is damaged or truncated: copy it again")
        (folder / f"{name}.uvh5").write_bytes(raw[:n_byte])
        (folder / f"{name}.uvh5.txt").write_text(message + "\n")
    for name, (*change, message) in INDEX_CASES.items():
        (folder / f"{name}.uvh5").write_bytes(spoilt(raw, *change))
        (folder / f"{name}.uvh5.txt").write_text(message + "; the file is damaged or truncated: copy it again\n")


if __name__ == "__main__":
    main()
