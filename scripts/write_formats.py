#!/usr/bin/env python3
"""Writes a file in every format, by pyuvdata.

    write_formats.py field.uvfits FOLDER

makes FOLDER/a.uvfits, a.uvh5 and a.ms. Needs pyuvdata and python-casacore.
"""

import pathlib
import sys

from pyuvdata import UVData

source, folder = sys.argv[1], pathlib.Path(sys.argv[2])
data = UVData.from_file(source)
data.write_uvfits(folder / "a.uvfits")
data.write_uvh5(folder / "a.uvh5")
data.write_ms(str(folder / "a.ms"))
