"""The matched filter that knows every galaxy: true shape at the true place, all others taken out.

Numpy and astropy alone: no model of ours.
"""

import numpy as np
from astropy.io import fits
from astropy.table import Table

from make_field import ARCSEC, shape

# Visibilities of models that are in memory at a time.
MOST_MODELS = 25_000_000


def oracle_snr(data, truth):
    """[X / sqrt(Y) in the data, expected signal-to-noise ratio] of each galaxy of a field of `vis2cat simulate`."""
    sky = Table.read(truth)
    with fits.open(data, memmap=True) as hdus:
        groups = hdus[0].data
        header = hdus[0].header
        freq_hz = next(header[f"CRVAL{i}"] for i in range(2, 8) if header.get(f"CTYPE{i}") == "FREQ")
        ra0, dec0 = (next(header[f"CRVAL{i}"] for i in range(2, 8) if header.get(f"CTYPE{i}") == name)
                     for name in ("RA", "DEC"))
        l, m = direction_cosines(sky, np.deg2rad(ra0), np.deg2rad(dec0))
        noise, power = np.zeros(len(sky)), np.zeros(len(sky))
        chunk = MOST_MODELS // max(len(sky), 1)
        for first in range(0, len(groups), chunk):
            x, y = sums(groups[first:first + chunk], freq_hz, sky, l, m)
            noise, power = noise + x, power + y
    return np.stack([noise / np.sqrt(power), np.sqrt(power)], 1).tolist()


def direction_cosines(sky, ra0, dec0):
    ra, dec = np.deg2rad(np.array(sky["RA"])), np.deg2rad(np.array(sky["DEC"]))
    l = np.cos(dec) * np.sin(ra - ra0)
    m = np.sin(dec) * np.cos(dec0) - np.cos(dec) * np.sin(dec0) * np.cos(ra - ra0)
    return l, m


def sums(groups, freq_hz, sky, l, m):
    """Sums of w Re(m* (d - all other models)) and of w |m|^2 over some rows, for each galaxy."""
    uvw = np.stack([groups.par(name).astype(float) for name in ("UU", "VV", "WW")], 1) * freq_hz
    cells = groups.data.reshape(len(groups), -1, 3).astype(float)
    weight = np.clip(cells[:, :2, 2], 0, None)
    stokes_i = (weight * cells[:, :2, 0]).sum(1), (weight * cells[:, :2, 1]).sum(1)
    weight = weight.sum(1)
    left = (stokes_i[0] + 1j * stokes_i[1]) / np.where(weight > 0, weight, 1)
    models = []
    for k, row in enumerate(sky):
        n_1 = np.sqrt(1 - l[k] ** 2 - m[k] ** 2) - 1
        cycles = uvw @ np.array([l[k], m[k], n_1])
        amplitude = row["Total_flux"] * 1e-6 * shape(uvw, row["Scale_length"] * ARCSEC, row["E1"], row["E2"])
        models.append((amplitude * np.exp(2j * np.pi * (cycles - np.rint(cycles)))).astype(np.complex64))
        left = left - models[-1]
    x = [(weight * (model.conj() * (left + model)).real).sum() for model in models]
    y = [(weight * np.abs(model) ** 2).sum() for model in models]
    return np.array(x, float), np.array(y, float)
