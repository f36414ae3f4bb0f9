#!/usr/bin/env python3
"""Check that no table that casacore writes is taken for a damaged one: random tables, read by vis2cat.

    check_tables.py [--seeds FIRST LAST] [--program target/release/vis2cat]

Each is the HISTORY of a small Measurement Set: columns of any type in standard and incremental storage managers,
cells left empty, rows and columns added and removed. The messages must be those that python-casacore has.
Build first: `cargo build --release`. Needs python-casacore.
"""

import argparse
import json
import pathlib
import random
import shutil
import subprocess
import sys
import tarfile
import tempfile

import numpy as np
from casacore import tables

ROOT = pathlib.Path(__file__).resolve().parent.parent
TYPES = ["boolean", "uchar", "short", "int", "uint", "int64", "float", "double", "complex", "dcomplex", "string"]
# In the cell, elsewhere, and longer than a bucket.
TEXT_LENGTHS = [0, 3, 8, 9, 30, 200, 3000]
FIXED, DIRECT_FIXED = 4, 5


def manager(rng):
    name = rng.choice(["StandardStMan", "IncrementalStMan"])
    return {"datamanagertype": name, "datamanagergroup": f"{name}{rng.randrange(3)}"}


def column(rng, name):
    kind = rng.choice(TYPES)
    like = {"boolean": True, "string": ""}.get(kind, 0)
    options = manager(rng) | {"valuetype": kind}
    layout = rng.choice(["scalar", "scalar", "direct", "fixed", "any"])
    if layout == "scalar":
        longest = rng.choice([0, 0, 5, 20]) if kind == "string" else 0
        return tables.makescacoldesc(name, like, maxlen=longest, **options)
    if layout == "any":
        return tables.makearrcoldesc(name, like, ndim=1, **options)
    shape = [rng.randint(1, 3), rng.randint(1, 4)]
    options["options"] = DIRECT_FIXED if layout == "direct" else FIXED
    return tables.makearrcoldesc(name, like, ndim=2, shape=shape, **options)


def value(rng, description):
    if description["valueType"] == "string":
        text = "x" * rng.choice(TEXT_LENGTHS)
        return text[:description["maxlen"]] if description.get("maxlen") else text
    return rng.random() < 0.5 if description["valueType"] == "boolean" else rng.randint(0, 100)


def fill(rng, table, columns):
    for name, description in ((column["name"], column["desc"]) for column in columns):
        for row in (row for row in range(table.nrows()) if rng.random() < 0.7):
            if "ndim" not in description:
                table.putcell(name, row, value(rng, description))
                continue
            shape = [int(n) for n in description.get("shape", [])] or [rng.randint(1, 4)]
            cells = [value(rng, description) for _ in range(int(np.prod(shape)))]
            table.putcell(name, row, np.array(cells).reshape(shape))


def make(rng, path):
    """Writes a table; returns its messages."""
    columns = [column(rng, f"C{i}") for i in range(rng.randint(1, 8))]
    columns.append(tables.makescacoldesc("MESSAGE", "", valuetype="string", **manager(rng)))
    rng.shuffle(columns)
    n_row = rng.choice([0, 1, 5, 40, 300])
    with tables.table(str(path), tables.maketabdesc(columns), nrow=n_row, ack=False,
                      endian=rng.choice(["little", "big"])) as table:
        fill(rng, table, columns)
        for _ in range(rng.randint(0, 3)):
            if table.nrows() > 3 and rng.random() < 0.5:
                table.removerows(sorted(rng.sample(range(table.nrows()), table.nrows() // 3)))
            else:
                table.addrows(rng.randint(0, 50))
            if rng.random() < 0.5:
                fill(rng, table, columns)
        if rng.random() < 0.3:
            options = manager(rng)
            table.addcols(tables.makescacoldesc("LATE", 0.5, valuetype="double", **options))
        return [table.getcell("MESSAGE", row) for row in range(table.nrows())]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seeds", type=int, nargs=2, default=[0, 100], metavar=("FIRST", "LAST"))
    parser.add_argument("--program", type=pathlib.Path, default=ROOT / "target/release/vis2cat")
    given = parser.parse_args()
    first, last = given.seeds
    n_wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        with tarfile.open(ROOT / "fixtures/good/ms_small.ms.tar.gz") as archive:
            archive.extractall(folder, filter="data")
        path = pathlib.Path(folder) / "ms_small.ms"
        for seed in range(first, last):
            shutil.rmtree(path / "HISTORY")
            wanted = make(random.Random(seed), path / "HISTORY")
            run = subprocess.run([given.program, "info", path, "--json"],
                                 capture_output=True, text=True)
            ok = run.returncode == 0
            found = json.loads(run.stdout)["observation"]["history"] if ok else run.stderr.strip()
            if found != wanted:
                n_wrong += 1
                print(f"seed {seed}: {found}")
    print(f"{last - first} tables, {n_wrong} of them read wrongly")
    sys.exit(n_wrong > 0)


if __name__ == "__main__":
    main()
