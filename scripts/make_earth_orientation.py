#!/usr/bin/env python3
"""Write the daily Earth orientation table that `vis2cat simulate` carries.

    pip install astropy astropy-iers-data
    scripts/make_earth_orientation.py > src/simulate/earth_orientation.csv

Source: the IERS series finals2000A.all with the final Bulletin B values where there are any, as the
package astropy-iers-data (IERS data are free to use) hands them to astropy: the very numbers, in the units of
their last digit, that astropy and pyuvdata interpolate between.
"""

import astropy_iers_data
from astropy.utils import iers

FIRST_MJD = 57754  # 2017-01-01, the day after the last leap second
LAST_MJD = 61042  # 2026-01-02


def integer(value, unit):
    scaled = float(value) / unit
    nearest = round(scaled)
    assert abs(scaled - nearest) < 1e-3, "the table has more digits than the integers hold"
    return nearest


def main():
    iers.conf.auto_download = False
    table = iers.earth_orientation_table.get()
    mjd = table["MJD"].value
    print("# UT1-UTC and pole of each day at 0 h UTC from 2017-01-01 (MJD 57754) on, no leap second within.")
    print("# IERS finals2000A.all with Bulletin B, by way of astropy-iers-data", astropy_iers_data.__version__)
    print("# Made by scripts/make_earth_orientation.py")
    print("ut1_utc_100ns,x_pole_uas,y_pole_uas")
    for day in range(FIRST_MJD, LAST_MJD + 1):
        row = table[mjd == day]
        assert len(row) == 1 and row["UT1Flag"][0] == "B" and row["PolPMFlag"][0] == "B", day
        print(
            integer(row["UT1_UTC"][0].value, 1e-7),
            integer(row["PM_x"][0].value, 1e-6),
            integer(row["PM_y"][0].value, 1e-6),
            sep=",",
        )


if __name__ == "__main__":
    main()
