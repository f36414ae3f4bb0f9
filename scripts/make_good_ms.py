#!/usr/bin/env python3
"""Make fixtures/good/*.ms.tar.gz: tiny Measurement Sets, always the same, but for some bytes that
mean nothing and that casacore leaves to chance.

    make_good_ms.py [FOLDER]

Written by pyuvdata (3.2 or later) over python-casacore, and then changed with python-casacore into
what other writers make. A set is a directory of many small files, most of them alike: it is kept as
one archive, which the tests unpack. Each has a JSON beside it with what a reader must find in it,
as `make_good_uvfits.py` has it; ms_NAME.ms holds the observation of pyuvdata_NAME.uvfits where
there is one.
"""

import gzip
import io
import json
import pathlib
import shutil
import sys
import tarfile
import tempfile

import numpy as np
from astropy.time import Time
from casacore import tables
from pyuvdata import UVData

from make_good_uvfits import ROOT, observe

LINEAR = [-5, -6]
CIRCULAR = [-1, -2, -3, -4]


def plain(seed, n_spw=1, pols=LINEAR, n_source=1, n_chan=2):
    """The observation that variants start from."""
    return observe([0, 1, 5, 7], 3, n_spw, n_chan, pols, n_source, seed)


def change(path, name=""):
    return tables.table(str(path / name), readonly=False, ack=False)


def add_column(path, name, like, factor):
    """A column of other visibilities, filled."""
    with change(path) as t:
        description = tables.makecoldesc(name, t.getcoldesc(like))
        t.addcols(description, t.getdminfo(like) | {"NAME": f"Tiled{name}"})
        t.putcol(name, (factor * t.getcol(like)).astype("c8"))


def with_corrected(path):
    """CORRECTED_DATA and MODEL_DATA beside DATA."""
    add_column(path, "CORRECTED_DATA", "DATA", 2)
    add_column(path, "MODEL_DATA", "DATA", 3)


def with_empty_corrected(path):
    """CORRECTED_DATA without cells, and WEIGHT_SPECTRUM too: WEIGHT stands for all channels."""
    with change(path) as t:
        t.addcols(tables.makearrcoldesc("CORRECTED_DATA", 0j, 2, valuetype="complex"))
        t.removecols("WEIGHT_SPECTRUM")
        t.addcols(tables.makearrcoldesc("WEIGHT_SPECTRUM", 0.0, 2, valuetype="float"))


def with_sigma_only(path):
    """Standard deviations of each channel, and no weights."""
    with change(path) as t:
        weights = t.getcol("WEIGHT_SPECTRUM")
        t.removecols(["WEIGHT_SPECTRUM", "WEIGHT"])
        t.addcols(tables.makearrcoldesc("SIGMA_SPECTRUM", 0.0, 2, valuetype="float"))
        t.putcol("SIGMA_SPECTRUM", (2.0 ** -np.round(weights)).astype("f4"))


def with_flagged_rows(path):
    """A row that is flagged as a whole, and an antenna."""
    with change(path) as t:
        rows = t.getcol("FLAG_ROW")
        rows[3] = True
        t.putcol("FLAG_ROW", rows)
    with change(path, "ANTENNA") as t:
        rows = t.getcol("FLAG_ROW")
        rows[5] = True
        t.putcol("FLAG_ROW", rows)


def with_standard_storage(path):
    """All columns in the storage manager that is not made for large arrays."""
    with change(path) as t:
        for name in ("DATA", "FLAG", "WEIGHT_SPECTRUM", "UVW"):
            cells = t.getcol(name)
            description = t.getcoldesc(name)
            keywords = t.getcolkeywords(name)
            t.removecols(name)
            for key in ("dataManagerType", "dataManagerGroup"):
                description[key] = "StandardStMan"
            t.addcols(tables.makecoldesc(name, description))
            t.putcol(name, cells)
            t.putcolkeywords(name, keywords)


def with_frames_by_field(path):
    """A code for the frame of each field, beside its direction."""
    with change(path, "FIELD") as t:
        t.addcols(tables.makescacoldesc("PhaseDir_Ref", 0))
        t.putcol("PhaseDir_Ref", np.array([21, 0]))
        t.putcolkeyword("PHASE_DIR", "MEASINFO", {
            "type": "direction", "VarRefCol": "PhaseDir_Ref",
            "TabRefTypes": ["J2000", "B1950", "ICRS"], "TabRefCodes": np.array([0, 4, 21], dtype="u4")})


def to_stokes_i(path):
    """The one correlation is I, which pyuvdata does not write."""
    with change(path, "POLARIZATION") as t:
        t.putcell("CORR_TYPE", 0, [1])


def with_big_endian(path):
    """The same set as a machine of the other byte order writes it."""
    copy = path.with_suffix(".copy")
    with tables.table(str(path), ack=False) as t:
        t.copy(str(copy), deep=True, valuecopy=True, endian="big").close()
    shutil.rmtree(path)
    copy.rename(path)


def to_selection(path):
    """No more than a list of rows of another set, as a selection is kept, beside which that must be."""
    whole = path.with_name("whole.ms")
    path.rename(whole)
    with tables.table(str(whole), ack=False) as t:
        t.query("ANTENNA1 != ANTENNA2 and ROWNR() > 2").copy(str(path), deep=False).close()


# Name, observation, what is changed afterwards.
CASES = [
    ("small", lambda: observe([1, 2, 3, 4], 3, 1, 2, LINEAR, 1, 1), None),
    ("large_numbers", lambda: observe([1, 255, 256, 600, 2049], 2, 1, 1, [-5, -6, -7, -8], 1, 3), None),
    ("stokes_i", lambda: observe([1, 2, 3], 4, 1, 3, [-5], 1, 4), to_stokes_i),
    ("sources", lambda: plain(30, pols=CIRCULAR, n_source=2), None),
    ("windows", lambda: plain(31, n_spw=3), None),
    ("corrected", lambda: plain(32), with_corrected),
    ("empty_columns", lambda: plain(33), with_empty_corrected),
    ("sigma", lambda: plain(34), with_sigma_only),
    ("flagged_rows", lambda: plain(35), with_flagged_rows),
    ("standard_storage", lambda: plain(36), with_standard_storage),
    ("frames_by_field", lambda: plain(37, n_source=2), with_frames_by_field),
    ("big_endian", lambda: plain(38), with_big_endian),
    ("selection", lambda: plain(39), to_selection),
]


def weights_of(t):
    """What a reader makes of the columns of weights."""
    names = t.colnames()
    shape = t.getcol("FLAG").shape
    if "WEIGHT_SPECTRUM" in names and t.iscelldefined("WEIGHT_SPECTRUM", 0):
        return t.getcol("WEIGHT_SPECTRUM")
    if "WEIGHT" in names:
        return np.broadcast_to(t.getcol("WEIGHT")[:, np.newaxis], shape)
    return 1 / t.getcol("SIGMA_SPECTRUM") ** 2


def expectation(path):
    """What a reader must find, as python-casacore sees it."""
    with tables.table(str(path), ack=False) as t, \
            tables.table(t.getkeyword("ANTENNA"), ack=False) as antennas, \
            tables.table(t.getkeyword("FIELD"), ack=False) as fields, \
            tables.table(t.getkeyword("SPECTRAL_WINDOW"), ack=False) as windows:
        corrected = "CORRECTED_DATA" in t.colnames() and t.iscelldefined("CORRECTED_DATA", 0)
        data = t.getcol("CORRECTED_DATA" if corrected else "DATA")
        weights = weights_of(t)
        ants = np.stack([t.getcol("ANTENNA1"), t.getcol("ANTENNA2")])
        bad_rows = t.getcol("FLAG_ROW") | antennas.getcol("FLAG_ROW")[ants].any(axis=0)
        good = ~t.getcol("FLAG") & ~bad_rows[:, np.newaxis, np.newaxis] & (weights > 0)
        total = np.sum(data[good].astype("c16"))
        uvw = t.getcol("UVW")
        return {
            "n_row": t.nrows(),
            "n_chan": data.shape[1],
            "n_corr": data.shape[2],
            "n_antenna": int(np.any(antennas.getcol("POSITION") != 0, axis=1).sum()),
            "n_flagged": int((~good).sum()),
            "sum_vis": [total.real, total.imag],
            "sum_weight": float(np.sum(weights[good].astype("f8"))),
            "sum_uvw_m": [float(x) for x in uvw.sum(axis=0)],
            "first_uvw_m": [float(x) for x in uvw[1]],
            "first_vis": [float(data[1, 0, 0].real), float(data[1, 0, 0].imag)],
            "first_ant": [int(a) for a in ants[:, 1]],
            "first_mjd": float(t.getcell("TIME", 0)) / 86400,
            "freq_hz": [float(f) for f in windows.getcell("CHAN_FREQ", 0)],
            "fields": [[name, float(fields.getcell("PHASE_DIR", i)[0, 0]),
                        float(fields.getcell("PHASE_DIR", i)[0, 1])]
                       for i, name in enumerate(fields.getcol("NAME"))],
        }


def compare_with_pyuvdata(path, wanted):
    """pyuvdata, which knows the signs that it wrote, must see the same baselines and visibilities."""
    uv = UVData()
    uv.read_ms(str(path), ignore_single_chan=False, run_check=False)
    if uv.Nspws > 1:
        return
    assert np.allclose(-uv.uvw_array.sum(axis=0), wanted["sum_uvw_m"], atol=1e-8), path
    assert np.isclose(Time(uv.time_array[0], format="jd").mjd, wanted["first_mjd"], atol=1e-9)
    vis = np.conj(uv.data_array[1, 0, 0])
    assert [vis.real, vis.imag] == wanted["first_vis"], path


def pack(folder, archive):
    """No times, no owners. Locks are part of a set: casacore keeps the number of rows there."""
    with open(archive, "wb") as out, gzip.GzipFile("", "wb", 9, out, mtime=0) as packed, \
            tarfile.open(fileobj=packed, mode="w", format=tarfile.USTAR_FORMAT) as tar:
        for path in sorted(path for path in folder.rglob("*") if path.parent != folder):
            info = tarfile.TarInfo(str(path.relative_to(folder)))
            if path.is_dir():
                info.type, info.mode = tarfile.DIRTYPE, 0o755
                tar.addfile(info)
            else:
                content = path.read_bytes()
                info.size, info.mode = len(content), 0o644
                tar.addfile(info, io.BytesIO(content))


def main():
    folder = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "fixtures" / "good"
    folder.mkdir(parents=True, exist_ok=True)
    for name, make, alter in CASES:
        with tempfile.TemporaryDirectory() as temporary:
            path = pathlib.Path(temporary) / f"ms_{name}.ms"
            uv = make()
            uv.history = "made by make_good_ms.py"
            uv.write_ms(str(path), run_check=False)
            with change(path, "HISTORY") as t:
                # Not the time at which this was run.
                t.putcol("TIME", np.zeros(t.nrows()))
            compare_with_pyuvdata(path, expectation(path))
            if alter:
                alter(path)
            wanted = expectation(path)
            archive = folder / f"ms_{name}.ms.tar.gz"
            pack(path.parent, archive)
            (folder / f"ms_{name}.json").write_text(json.dumps(wanted, indent=1) + "\n")
            print(archive, archive.stat().st_size)


if __name__ == "__main__":
    main()
