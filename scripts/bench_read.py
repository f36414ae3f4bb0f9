#!/usr/bin/env python3
"""Time reading a UVFITS or UVH5 file, ours against pyuvdata's; a Measurement Set against casacore.

    bench_read.py FILE [--megabytes 300]

The rows of FILE are repeated until the file has the size wanted; UVH5 is chunked and compressed
as pyuvdata does it. Both readers run in processes of their own with the file in the page cache; the
fastest of five passes counts for us, of three for pyuvdata (metadata checks off). Build first:
`cargo build --release -p vis2cat-formats --examples`. UVH5 needs h5py, Measurement Sets python-casacore,
which reads with getcol, 4096 rows at a time, the columns that we read.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
BLOCK = 2880

THEIRS = """
import json, resource, sys, time, warnings
warnings.simplefilter("ignore")
from pyuvdata import UVData
best = 1e9
for _ in range(3):
    start = time.perf_counter()
    uv = UVData()
    if sys.argv[1].endswith(".uvh5"):
        uv.read_uvh5(sys.argv[1], run_check=False, fix_old_proj=False)
    else:
        uv.read_uvfits(sys.argv[1], run_check=False, fix_old_proj=False)
    best = min(best, time.perf_counter() - start)
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
print(json.dumps({"seconds": best, "rows": int(uv.Nblts), "peak_mb": peak}))
"""


CASACORE = """
import json, resource, sys, time
from casacore.tables import table
best = 1e9
for _ in range(5):
    start = time.perf_counter()
    main = table(sys.argv[1], ack=False)
    n_row = main.nrows()
    weights = next(name for name in ("WEIGHT_SPECTRUM", "WEIGHT") if name in main.colnames()
                   and main.iscelldefined(name, 0))
    columns = ["DATA", "FLAG", weights, "UVW", "TIME", "ANTENNA1", "ANTENNA2", "FIELD_ID", "DATA_DESC_ID",
               "FLAG_ROW", "EXPOSURE"]
    for first in range(0, n_row, 4096):
        for name in columns:
            main.getcol(name, first, min(4096, n_row - first))
    main.close()
    best = min(best, time.perf_counter() - start)
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
print(json.dumps({"seconds": best, "rows": n_row, "peak_mb": peak}))
"""


def inflate_ms(source, target, wanted_bytes):
    """Repeats the rows of a set, which has the storage managers of the original."""
    from casacore.tables import table

    old = table(str(source), ack=False)
    old.copy(str(target), deep=True).close()
    n_byte = sum(path.stat().st_size for path in source.rglob("*") if path.is_file())
    n_row = old.nrows()
    new = table(str(target), readonly=False, ack=False)
    for i in range(1, max(1, wanted_bytes // n_byte)):
        new.addrows(n_row)
        old.copyrows(new, 0, i * n_row, n_row)
    new.close()


def inflate_uvh5(source, target, wanted_bytes):
    """Repeats the rows of a file; their times may be those of other rows."""
    import h5py
    import numpy as np

    with h5py.File(source) as old, h5py.File(target, "w") as new:
        n_row = int(old["Header/Nblts"][()])
        n_byte = sum(old["Data"][name].nbytes for name in old["Data"])
        times = max(1, wanted_bytes // n_byte)
        old.copy("Header", new)
        for name, array in old["Header"].items():
            if isinstance(array, h5py.Dataset) and array.shape and array.shape[0] == n_row \
                    and name.endswith(PER_ROW):
                del new["Header"][name]
                new["Header"][name] = np.concatenate([array[()]] * times)
        new["Header/Nblts"][()] = n_row * times
        for name, array in old["Data"].items():
            packing = None if name == "visdata" else "lzf"
            made = new.create_dataset(f"Data/{name}", (n_row * times, *array.shape[1:]),
                                      array.dtype, chunks=True, compression=packing)
            some = max(1, 10**7 // array.nbytes)
            rows = np.concatenate([array[()]] * some)
            for at in range(0, len(made), len(rows)):
                made[at:at + len(rows)] = rows[:len(made) - at]


PER_ROW = ("uvw_array", "time_array", "integration_time", "lst_array", "ant_1_array", "ant_2_array",
           "phase_center_id_array", "app_ra", "app_dec", "frame_pa")


def inflate_uvfits(source, target, wanted_bytes):
    """Repeats the groups of a file."""
    raw = source.read_bytes()
    cards = [raw[i:i + 80] for i in range(0, len(raw), 80)]
    n_card = next(i for i, card in enumerate(cards) if card[:8] == b"END     ")
    value = {c[:8].decode().strip(): c[10:30].decode().strip() for c in cards[:n_card]
             if c[8:10] == b"= "}
    n_axis = int(value["NAXIS"])
    size = int(value["PCOUNT"])
    data = 1
    for i in range(2, n_axis + 1):
        data *= int(value[f"NAXIS{i}"])
    n_group = int(value["GCOUNT"])
    n_byte = abs(int(value["BITPIX"])) // 8 * (size + data) * n_group
    start = -(-(n_card + 1) * 80 // BLOCK) * BLOCK
    after = start + -(-n_byte // BLOCK) * BLOCK
    times = max(1, wanted_bytes // n_byte)
    head = bytearray(raw[:start])
    at = head.index(b"GCOUNT  =")
    head[at + 10:at + 30] = f"{n_group * times:>20}".encode()
    with target.open("wb") as out:
        out.write(head)
        for _ in range(times):
            out.write(raw[start:start + n_byte])
        out.write(bytes(-(n_byte * times) % BLOCK))
        out.write(raw[after:])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", type=pathlib.Path)
    parser.add_argument("--megabytes", type=int, default=300)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        big = pathlib.Path(folder) / f"big{arguments.file.suffix}"
        inflate = {".uvh5": inflate_uvh5, ".ms": inflate_ms}.get(big.suffix, inflate_uvfits)
        inflate(arguments.file, big, arguments.megabytes * 10**6)
        run = lambda *command: json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
        ours = run(ROOT / "target/release/examples/read_speed", big)
        # pyuvdata refuses a set with a row twice.
        name, code = ("casacore", CASACORE) if big.suffix == ".ms" else ("pyuvdata", THEIRS)
        theirs = run(sys.executable, "-c", code, big)
    assert ours["rows"] == theirs["rows"]
    print(f"{arguments.file.name}: {ours['bytes'] / 1e6:.0f} MB, {ours['rows']} rows")
    print(f"ours     {ours['seconds']:.3f} s, {ours['mb_per_s']:.0f} MB/s, peak {ours['peak_mb']:.0f} MB")
    print(f"{name} {theirs['seconds']:.3f} s, peak {theirs['peak_mb']:.0f} MB, "
          f"{theirs['seconds'] / ours['seconds']:.2f} times as long")


if __name__ == "__main__":
    main()
