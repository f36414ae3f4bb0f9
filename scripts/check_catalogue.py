#!/usr/bin/env python3
"""Checks FITS tables with the tools that users will open them with.

Usage: check_catalogue.py FILE...

fitsverify: no error and no warning. astropy: checksums hold, warnings are errors, units and UCDs are
in their vocabularies, no DATE and no EQUINOX. STILTS: every table is read without a word on stderr.
A tool that is not installed is skipped and said so; exit status 1 if any check fails.
"""

import importlib.util
import re
import shutil
import subprocess
import sys
import warnings


def run(*command):
    return subprocess.run(command, capture_output=True, text=True, check=False)


def table_names(path):
    """Names of all binary tables, read from the raw headers."""
    with open(path, "rb") as file:
        blocks = iter(lambda: file.read(2880), b"")
        heads = [b for b in blocks if b.startswith(b"XTENSION= 'BINTABLE'")]
    return [re.search(rb"EXTNAME = '([^']*?) *'", h).group(1).decode() for h in heads]


def check_fitsverify(path):
    quiet = run("fitsverify", "-q", path)
    if not quiet.stdout.startswith("verification OK"):
        yield quiet.stdout.strip()
    full = run("fitsverify", path)
    if "0 warning(s) and 0 error(s)" not in full.stdout or full.returncode:
        yield full.stdout


def check_stilts(path):
    for name in table_names(path):
        for output in (["omode=stats"], ["cmd=meta", "ofmt=csv"]):
            done = run("stilts", "tpipe", f"in={path}#{name}", "ifmt=fits", *output)
            if done.returncode or done.stderr:
                yield f"{name}: {done.stderr.strip()}"


def check_astropy(path):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", ResourceWarning)  # Of astropy, after a failure.
        try:
            yield from astropy_complaints(path)
        except Exception as error:  # A warning or failure of any kind is what is looked for.
            yield f"{type(error).__name__}: {error}"


def astropy_complaints(path):
    from astropy.io import fits
    from astropy.io.votable.ucd import check_ucd
    from astropy.table import Table
    from astropy.units import Unit

    with fits.open(path, checksum=True) as hdus:
        hdus.verify("exception")
        for number, hdu in enumerate(hdus):
            for key in ("CHECKSUM", "DATASUM", "ORIGIN"):
                if key not in hdu.header:
                    yield f"HDU {number}: no {key}"
            for key in ("EQUINOX", "DATE"):
                if key in hdu.header:
                    yield f"HDU {number}: {key} must not be there"
            for key, value in hdu.header.items():
                if key.startswith("TUCD") and not check_ucd(value, True, True):
                    yield f"HDU {number}: {key} = {value} is not in UCD1+"
                if key.startswith("TUNIT"):
                    Unit(value, format="fits")
            if number:
                table = Table.read(path, hdu=number)
                if len(table) != hdu.header["NAXIS2"]:
                    yield f"HDU {number}: {len(table)} rows"


def main(paths):
    tools = {
        "fitsverify": (check_fitsverify, shutil.which("fitsverify")),
        "stilts": (check_stilts, shutil.which("stilts")),
        "astropy": (check_astropy, importlib.util.find_spec("astropy")),
    }
    failed = False
    for name, (check, present) in tools.items():
        if not present:
            print(f"SKIPPED {name}: not installed")
            continue
        for path in paths:
            complaints = list(check(path))
            failed = failed or bool(complaints)
            print("FAILED" if complaints else "ok", name, path, *complaints, sep="  ")
    return 1 if failed else 0


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1:]))
