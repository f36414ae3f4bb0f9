#!/usr/bin/env python3
"""Write the antenna tables that `vis2cat simulate` carries.

    scripts/make_arrays.py FOLDER

FOLDER holds one CSV a layout (columns name, x_m, y_m, z_m, diameter_m; geocentric ITRF) made from

* skamid_{AA1,AA2,AAstar,AA4}_ostconfig2.3.1: SKAO's ska-ost-array-config 2.3.1, as exported in the
  MIT-licensed Karabo-Pipeline (karabo/data/SKA-MID-*.ska-ost-array-config-2.3.1.tm): ENU about 21.443803 E
  30.712925 S, height 1095.967 m; dish names from the SKA1-MID list of SKAO. The M dishes are MeerKAT's;
  the first of them is 4 cm from SARAO's published place.
* vla_{a,b,c,d}_casa and atca_{6a,1.5a}_casa: the pads of NRAO's VLA and CSIRO's ATCA, as in the
  configuration files of the Python package casadata 2025.9.22 (simmos/*.cfg).

Only facts are taken (name, ITRF position, diameter), in a layout of our own, to the millimetre.
Values of sefd_jy are for L band: SKA1-MID dish 400 Jy and MeerKAT dish 551 Jy, the planning
values of the simulations of Rivi et al. (2016) and Malyali et al. (2018), VLA 420 Jy (NRAO,
Observational Status Summary).
"""

import csv
import pathlib
import sys

OUT = pathlib.Path(__file__).resolve().parent.parent / "src" / "simulate" / "arrays"


def read(folder, layout):
    with open(folder / f"{layout}.csv", newline="") as file:
        return {row["name"]: row for row in csv.DictReader(file)}


def place(row):
    return tuple(float(row[key]) for key in ("x_m", "y_m", "z_m"))


def write(name, comment, member_column, rows, sefd_jy, member):
    with open(OUT / f"{name}.csv", "w") as file:
        for line in comment:
            print("#", line, file=file)
        print(f"name,x_m,y_m,z_m,diameter_m,sefd_jy,{member_column}", file=file)
        for row in rows:
            x, y, z = place(row)
            print(
                f"{row['name']},{x:.3f},{y:.3f},{z:.3f},{float(row['diameter_m']):g},{sefd_jy(row['name'])},{member(row['name'])}",
                file=file,
            )


def ska(folder):
    stages = ["AA1", "AA2", "AAstar", "AA4"]
    layouts = {stage: read(folder, f"skamid_{stage}_ostconfig2.3.1") for stage in stages}
    for early, late in zip(stages, stages[1:]):
        assert set(layouts[early]) <= set(layouts[late]), "a stage drops a dish"
    write(
        "ska1_mid",
        [
            "SKA1-MID: ITRF positions of the 133 SKA and 64 MeerKAT dishes, and the stage that first has each.",
            "From ska-ost-array-config 2.3.1 (SKAO) by way of Karabo-Pipeline (MIT); see scripts/make_arrays.py",
        ],
        "stage",
        layouts["AA4"].values(),
        lambda name: 551 if name.startswith("M") else 400,
        lambda name: next(stage for stage in stages if name in layouts[stage]),
    )


def pads(folder, name, comment, configs, sefd_jy):
    layouts = {config: read(folder, layout) for config, layout in configs.items()}
    rows = {}
    for layout in layouts.values():
        for pad, row in layout.items():
            known = rows.setdefault(pad, row)
            assert max(abs(a - b) for a, b in zip(place(known), place(row))) < 1e-3, f"{pad} moves"
    write(
        name,
        comment,
        "configs",
        rows.values(),
        lambda _: sefd_jy,
        lambda pad: " ".join(config for config, layout in layouts.items() if pad in layout),
    )


def main():
    folder = pathlib.Path(sys.argv[1])
    ska(folder)
    pads(
        folder,
        "vla",
        ["VLA: ITRF positions of the antenna pads, and the configurations that use each.", "From NRAO's positions as in casadata 2025.9.22; see scripts/make_arrays.py"],
        {config: f"vla_{config}_casa" for config in "abcd"},
        420,
    )
    pads(
        folder,
        "atca",
        ["ATCA: ITRF positions of the stations, and the configurations that use each.", "From CSIRO's positions as in casadata 2025.9.22; see scripts/make_arrays.py"],
        {"6a": "atca_6a_casa", "1.5a": "atca_1.5a_casa"},
        "",
    )


if __name__ == "__main__":
    main()
