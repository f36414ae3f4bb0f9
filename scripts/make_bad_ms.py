#!/usr/bin/env python3
"""Make fixtures/bad/*.ms.tar.gz: small Measurement Sets that are wrong in one way each.

    make_bad_ms.py [FOLDER]

Beside each stands a .txt with the message that the reader must give, without the path in front.
Needs nothing but Python: bytes are replaced in a set of fixtures/good.
"""

import gzip
import io
import pathlib
import struct
import sys
import tarfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
GOOD = ROOT / "fixtures" / "good" / "ms_standard_storage.ms.tar.gz"
# Tables that are not read.
LEFT_OUT = ["FEED", "FLAG_CMD", "POINTING", "PROCESSOR", "SOURCE", "STATE"]

# The file, what is replaced in it where it last stands, by what, the message. casacore crashes on each,
# fills the memory, or reads what is not there.
CASES = {
    "column_class_unknown": ("FIELD/table.dat", b"ScalarColumnDesc<Int     ", b"ScalarColumnDesc<Integer ",
        "table FIELD: cannot be read (a column is of a class that casacore does not know)"),
    "tile_empty": ("table.f4", struct.pack(">4i", 1, 2, 2, 16384), struct.pack(">4i", 1, 2, 2, 0),
        "table MAIN: cannot be read (table.f4: hypercube 1: [2, 30] cannot be cut into tiles of [2, 0])"),
    "tile_huge": ("table.f4", struct.pack(">4i", 1, 2, 2, 16384), struct.pack(">4i", 1, 2, 2, 1 << 30),
        "table MAIN: cannot be read (table.f4: hypercube 1: is cut into tiles of [2, 1073741824], more than "
        "134217728 values each)"),
    "hypercube_in_no_file": ("table.f4", struct.pack(">3i", 2, 16384, 1), struct.pack(">3i", 2, 16384, -7),
        "table MAIN: cannot be read (table.f4: hypercube 1: is in file -7, which there is not)"),
    "hypercube_nowhere": ("table.f3", b"Block" + struct.pack(">3I", 1, 1, 1),
        b"Block" + struct.pack(">3I", 1, 1, 1 << 28),
        "table MAIN: cannot be read (table.f3: has rows in hypercube 268435456, of 2)"),
    "column_in_no_index": ("DATA_DESCRIPTION/table.dat", b"Block" + struct.pack(">5I", 1, 3, 0, 0, 0),
        b"Block" + struct.pack(">5I", 1, 3, 0, 1 << 16, 0),
        "table DATA_DESCRIPTION: cannot be read (table.f0: column POLARIZATION_ID: is in index 65536, of 1)"),
    "column_beyond_bucket": ("HISTORY/table.dat", struct.pack(">2I", 0x700, 0x880), struct.pack(">2I", 0x700, 0xafc),
        "table HISTORY: cannot be read (table.f0: column PRIORITY: has 384 bytes from byte 2812 on, of 2816 in a bucket)"),
    "text_nowhere": ("HISTORY/table.f0", struct.pack("<3I", 1, 32, 23), struct.pack("<3I", 1, 1000, 23),
        "table HISTORY: cannot be read (table.f0: column MESSAGE: row 0: 23 bytes of a text are at byte 1000 of "
        "bucket 1, which has 55)"),
    "value_nowhere": ("table.f14", struct.pack("<Id3I", 12, 8., 1, 0, 0), struct.pack("<Id3I", 12, 8., 1, 0, 1 << 24),
        "table MAIN: cannot be read (table.f14: bucket 0: column INTERVAL: a value at byte 16777216 goes beyond the "
        "others)"),
    "values_begin_late": ("table.f14", struct.pack("<Id3I", 12, 8., 1, 0, 0), struct.pack("<Id3I", 12, 8., 1, 5, 0),
        "table MAIN: cannot be read (table.f14: bucket 0: column INTERVAL: its rows are not in order)"),
    "keyword_huge": ("ANTENNA/table.dat", struct.pack(">I", 1) + b"m", struct.pack(">i", -2) + b"m",
        "table ANTENNA: cannot be read (table.dat: keywords: what it announces is not there: it is truncated or "
        "damaged)"),
    "row_number_wild": ("DATA_DESCRIPTION/table.f0", b"Block" + struct.pack("<3I", 1, 1, 1) + bytes(260),
        b"Block" + struct.pack("<3I", 1, 1, 1) + bytes(132) + b"\xff" * 128,
        "table SPECTRAL_WINDOW: has 1 rows, no row 18446744073709551615"),
    "buckets_huge": ("FIELD/table.f0", struct.pack("<3I", 2052, 2, 2), struct.pack("<3I", 2052, 1 << 31, 2),
        "table FIELD: cannot be read (table.f0: announces 2147483648 buckets of 2052 bytes, has 4616 bytes)"),
    "cache_huge": ("table.f14", struct.pack("<3I", 1 << 15, 1, 1), struct.pack("<3I", 1 << 15, 1, 1 << 31),
        "table MAIN: cannot be read (table.f14: wants 2147483648 buckets in memory at once)"),
    "tiles_huge": ("table.f4", struct.pack(">3i", 2, 2, 30), struct.pack(">3i", 2, 1 << 30, 30),
        "table MAIN: cannot be read (table.f4: hypercube 1: [1073741824, 30] is cut into 536870912 tiles, in a file "
        "of 131072 bytes)"),
    "array_nowhere": ("table.f5", struct.pack("<2Q", 16, 64), struct.pack("<2Q", 16, 1 << 63),
        "table MAIN: cannot be read (table.f5: column DATA: row 1: an array is at byte 9223372036854775808 of its file, "
        "which has 2892)"),
    "manager_unnamed": ("table.f3", struct.pack(">I", 15) + b"TiledShape", struct.pack(">I", 15 << 16) + b"TiledShape",
        "table MAIN: cannot be read (table.f3: does not begin as that of a TiledShapeStMan does: it is truncated or "
        "damaged)"),
    "manager_silent": ("table.dat", struct.pack(">I", 3) + b"ISM", struct.pack(">I", 1 << 31) + b"ISM",
        "table MAIN: cannot be read (table.f20: what it announces is not there: it is truncated or damaged)"),
    "axes_huge": ("table.dat", b"TiledSigma" + struct.pack(">3I", 7, 0, 1),
        b"TiledSigma" + struct.pack(">3I", 7, 0, 1 << 30),
        "table MAIN: cannot be read (table.dat: column SIGMA has 1073741824 axes)"),
    "index_short": ("table.f6", b"SSMIndex" + struct.pack("<2I", 1, 1), b"SSMIndex" + struct.pack("<2I", 1, 1 << 24),
        "table MAIN: cannot be read (table.f6: index 0: has not the 16777216 buckets that it announces)"),
    "bucket_overfull": ("table.f6", b"Block" + struct.pack("<3I", 1, 1, 29), b"Block" + struct.pack("<3I", 1, 1, 99999),
        "table MAIN: cannot be read (table.f6: index 0: has rows 0 to 99999 in one bucket, which can have 32)"),
    "lock_huge": ("table.lock", struct.pack(">I4s", 133, b"\xbe" * 4), struct.pack(">I4s", 1 << 30, b"\xbe" * 4),
        "table MAIN: cannot be read (table.lock: what it announces is not there: it is truncated or damaged)"),
    "lock_list_huge": ("table.lock", b"Block" + struct.pack(">2I", 1, 19), b"Block" + struct.pack(">2I", 1, 1 << 31),
        "table MAIN: cannot be read (table.lock: announces a list of 2147483648 numbers, which is not there)"),
    "lock_of_no_layout": ("POLARIZATION/table.lock", b"sync" + struct.pack(">I", 1), b"sync" + struct.pack(">I", 0),
        "table POLARIZATION: cannot be read (table.lock: what it announces is not there: it is truncated or damaged)"),
    "record_huge": ("table.f4", struct.pack(">I", 10) + b"RecordDesc", struct.pack(">I", 1 << 31) + b"RecordDesc",
        "table MAIN: cannot be read (table.f4: hypercube 1: keywords: what it announces is not there: it is truncated "
        "or damaged)"),
    "indices_huge": ("FIELD/table.f0", struct.pack("<4I", 8, (1 << 32) - 1, 126, 1),
        struct.pack("<4I", 8, (1 << 32) - 1, 1 << 31, 1),
        "table FIELD: cannot be read (table.f0: announces 2147483648 bytes of indices, has 2044)"),
}


def files():
    """The files of the good set, by their names in it."""
    with tarfile.open(GOOD) as archive:
        for member in archive.getmembers():
            name = member.name.split("/", 1)[-1]
            if member.isfile() and name.split("/")[0] not in LEFT_OUT:
                yield name, archive.extractfile(member).read()


def make(folder, name, file, old, new):
    """An archive without anything of the day on which it is made."""
    plain = io.BytesIO()
    with tarfile.open(fileobj=plain, mode="w", format=tarfile.USTAR_FORMAT) as archive:
        for path, data in sorted(files()):
            if path == file:
                assert old in data, f"{name}: {old} is not in {file}"
                data = new.join(data.rsplit(old, 1))
            member = tarfile.TarInfo(f"{name}.ms/{path}")
            member.size = len(data)
            archive.addfile(member, io.BytesIO(data))
    (folder / f"{name}.ms.tar.gz").write_bytes(gzip.compress(plain.getvalue(), 9, mtime=0))


def main():
    folder = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "fixtures" / "bad"
    folder.mkdir(parents=True, exist_ok=True)
    for name, (file, old, new, message) in CASES.items():
        make(folder, name, file, old, new)
        (folder / f"{name}.ms.txt").write_text(message + "\n")


if __name__ == "__main__":
    main()
