#!/usr/bin/env python3
"""Make fixtures/bad/*.uvfits: small files that are wrong in one way each.

    make_bad_uvfits.py [FOLDER]

Beside each stands a .txt with the message that the reader must give, without the path in front.
Needs nothing but Python. The file that all cases start from is right in every way.
"""

import pathlib
import struct
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
BLOCK = 2880


def card(key, value):
    if isinstance(value, Raw):
        return f"{key:<8}= {value.text:>20}".ljust(80)
    if isinstance(value, bool):
        return f"{key:<8}= {'T' if value else 'F':>20}".ljust(80)
    if isinstance(value, str):
        return f"{key:<8}= '{value:<8}'".ljust(80)
    return f"{key:<8}= {value!r:>20}".replace("e", "E").ljust(80) if isinstance(value, float) \
        else f"{key:<8}= {value:>20}".ljust(80)


class Raw:
    """A value that is written as it stands."""

    def __init__(self, text):
        self.text = text


class Hdu:
    """Cards in order, and bytes."""

    def __init__(self, cards, data):
        self.cards, self.data, self.with_end = cards, data, True

    def set(self, **changes):
        """Changes cards, or takes them away where the new value is None."""
        self.cards = [(k, changes.pop(k, v)) for k, v in self.cards]
        self.cards = [(k, v) for k, v in self.cards if v is not None]
        self.cards += changes.items()

    def bytes(self):
        text = "".join(card(k, v) for k, v in self.cards) + ("END" if self.with_end else "")
        head = text.encode()
        head += b" " * (-len(head) % BLOCK)
        return head + self.data + b"\0" * (-len(self.data) % BLOCK)


PARAMETERS = ["UU", "VV", "WW", "DATE", "BASELINE", "INTTIM"]
AXES = [("COMPLEX", 3, 1.0, 1.0), ("STOKES", 2, -5.0, -1.0), ("FREQ", 2, 1.4e9, 1e6),
        ("RA", 1, 10.0, 1.0), ("DEC", 1, -30.0, 1.0)]


def group(row, baseline, **changes):
    """One group: 6 parameters and 2 channels x 2 hands of (1, 0, weight 1)."""
    values = {"UU": 1e-6 * row, "VV": 0.0, "WW": 0.0, "DATE": 0.25, "BASELINE": baseline, "INTTIM": 8.0}
    values.update(changes)
    return [values[name] for name in PARAMETERS] + [1.0, 0.0, 1.0] * 4


def good():
    """A right file: the primary HDU and the antenna table."""
    rows = [group(1, 258.0), group(2, 259.0), group(3, 515.0)]
    cards = [("SIMPLE", True), ("BITPIX", -32), ("NAXIS", 6), ("NAXIS1", 0)]
    cards += [(f"NAXIS{i}", a[1]) for i, a in enumerate(AXES, 2)]
    cards += [("EXTEND", True), ("GROUPS", True), ("PCOUNT", len(PARAMETERS)), ("GCOUNT", len(rows))]
    for i, (name, _, value, step) in enumerate(AXES, 2):
        cards += [(f"CTYPE{i}", name), (f"CRVAL{i}", value), (f"CDELT{i}", step), (f"CRPIX{i}", 1.0)]
    for i, name in enumerate(PARAMETERS, 1):
        cards += [(f"PTYPE{i}", name), (f"PSCAL{i}", 1.0), (f"PZERO{i}", 2460000.5 if name == "DATE" else 0.0)]
    cards += [("OBJECT", "BAD"), ("EPOCH", 2000.0)]
    flat = [value for row in rows for value in row]
    primary = Hdu(cards, struct.pack(f">{len(flat)}f", *flat))

    antennas = b"".join(struct.pack(">8s3di", b"ANT%d" % n, 5e6, 100.0 * n, 0.0, n) for n in (1, 2, 3))
    table = Hdu([("XTENSION", "BINTABLE"), ("BITPIX", 8), ("NAXIS", 2), ("NAXIS1", 36), ("NAXIS2", 3),
                 ("PCOUNT", 0), ("GCOUNT", 1), ("TFIELDS", 3),
                 ("TTYPE1", "ANNAME"), ("TFORM1", "8A"), ("TTYPE2", "STABXYZ"), ("TFORM2", "3D"),
                 ("TTYPE3", "NOSTA"), ("TFORM3", "1J"), ("EXTNAME", "AIPS AN"), ("EXTVER", 1),
                 ("ARRAYX", 0.0), ("ARRAYY", 0.0), ("ARRAYZ", 0.0)], antennas)
    return primary, table


def primary(**changes):
    """A case that changes cards of the primary header."""
    return lambda p, t: p.set(**changes)


def antennas(**changes):
    """A case that changes cards of the antenna table."""
    return lambda p, t: t.set(**changes)


def no_end(p, _):
    p.with_end = False


def replaced(at, **changes):
    """A case with other parameters in group `at`."""
    def change(p, _):
        row = struct.pack(">18f", *group(at, 258.0, **changes))
        p.data = p.data[:72 * (at - 1)] + row + p.data[72 * at:]
    return change


def cut(n_byte):
    """A case that ends after that many bytes."""
    return n_byte


HUGE = 2**62
CASES = {
    # Not FITS, not random groups.
    "empty": (cut(0), "file: is empty"),
    "text": (b"not a FITS file\n", "file: is no visibility file: not FITS, not HDF5"),
    "hdf5": (b"\x89HDF\r\n\x1a\n" + bytes(88), "file: cannot be read (H5Fopen(): unable to "
        "synchronously open file: bad byte number in an address); the file is damaged or truncated: "
        "copy it again"),
    "image": (primary(GROUPS=None, NAXIS1=1, PCOUNT=None, GCOUNT=None),
        "primary HDU: GROUPS: this FITS file has no random groups (GROUPS = T with NAXIS1 = "
        "0): no UVFITS file"),
    "uv_table": (b"".join(h.bytes() for h in [Hdu([("SIMPLE", True), ("BITPIX", 8), ("NAXIS", 2),
                 ("NAXIS1", 777777701), ("NAXIS2", 0), ("EXTEND", True)], b"")]),
        "primary HDU: NAXIS1 = 777777701: visibilities in a table (the AIPS FITAB form) are "
        "not read; write random groups instead, with FITTP in AIPS or with a converter"),
    # Truncated.
    "cut_in_primary_header": (cut(2000),
        "primary HDU: header: the file ends before the END card"),
    "cut_between_header_blocks": (cut(BLOCK),
        "primary HDU: header: the file ends before the END card"),
    "cut_in_data": (cut(2 * BLOCK + 100),
        "primary HDU: data: the header announces 216 bytes of data (padded to blocks of "
        "2880), the file has 100 left: it is truncated or the header is wrong"),
    "cut_before_antennas": (cut(3 * BLOCK),
        "file: AIPS AN: there is no antenna table; the file may be truncated"),
    "cut_in_antenna_header": (cut(3 * BLOCK + 500),
        "HDU 1: header: the file ends before the END card"),
    "cut_in_antennas": (cut(4 * BLOCK + 20),
        "HDU 1 (AIPS AN): data: the header announces 108 bytes of data (padded to blocks of "
        "2880), the file has 20 left: it is truncated or the header is wrong"),
    "header_without_end": (no_end,
        "primary HDU: header: an extension starts before the END card"),
    # Sizes that lie.
    "naxis_negative": (primary(NAXIS4=-8),
        "primary HDU: NAXIS4: is -8, must not be negative"),
    "naxis_too_many": (primary(NAXIS=1000),
        "primary HDU: NAXIS: is 1000, the standard allows 999"),
    "naxis_missing": (primary(NAXIS5=None),
        "primary HDU: NAXIS5: keyword is missing"),
    "naxis_overflow": (primary(NAXIS3=HUGE, NAXIS4=HUGE),
        "primary HDU: NAXIS: NAXISn, PCOUNT and GCOUNT multiply to more bytes than any file has"),
    "naxis_huge": (primary(NAXIS4=2**40),
        "primary HDU: data: the header announces 79164837199944 bytes of data (padded to "
        "blocks of 2880), the file has 8640 left: it is truncated or the header is wrong"),
    "naxis_zero": (primary(NAXIS4=0),
        "primary HDU: NAXIS4: is 0: the groups hold no visibilities"),
    "naxis_twice": (lambda p, t: p.cards.append(("NAXIS4", 1)),
        "primary HDU: NAXIS4: stands twice with different values"),
    "gcount_huge": (primary(GCOUNT=99999999),
        "primary HDU: data: the header announces 7199999928 bytes of data (padded to blocks "
        "of 2880), the file has 8640 left: it is truncated or the header is wrong"),
    "gcount_zero": (primary(GCOUNT=0),
        "primary HDU: GCOUNT: is 0: the file holds no visibilities"),
    "gcount_missing": (primary(GCOUNT=None),
        "primary HDU: GCOUNT: keyword is missing"),
    "gcount_text": (primary(GCOUNT="many"),
        "primary HDU: GCOUNT: must be a whole number, found 'many'"),
    "pcount_overflow": (primary(PCOUNT=2**63 - 1, GCOUNT=2**63 - 1),
        "primary HDU: NAXIS: NAXISn, PCOUNT and GCOUNT multiply to more bytes than any file has"),
    "pcount_many": (primary(PCOUNT=2000, GCOUNT=1, NAXIS4=1, NAXIS3=1),
        "primary HDU: PCOUNT: is 2000, at most 999 can be named"),
    "bitpix_wrong": (primary(BITPIX=12),
        "primary HDU: BITPIX: is 12, which no FITS data can be"),
    # Axes.
    "complex_missing": (primary(CTYPE2="SIMPLEX"),
        "primary HDU: CTYPE2: axis 'SIMPLEX' of length 3 is not known"),
    "complex_four": (primary(NAXIS2=4, GCOUNT=1),
        "primary HDU: NAXIS2: the COMPLEX axis has length 4, must be 2 or 3"),
    "stokes_unknown": (primary(CRVAL3=-8.0),
        "primary HDU: CRVAL3: value 2 of the STOKES axis is -9, no known code"),
    "freq_missing": (primary(CTYPE4="CHANNEL", NAXIS4=1),
        "primary HDU: CTYPE: there is no FREQ axis"),
    "freq_no_value": (primary(CRVAL4=None),
        "primary HDU: CRVAL4: keyword is missing"),
    "freq_zero": (primary(CRVAL4=0.0),
        "primary HDU: CRVAL4: frequency 0 Hz is not positive"),
    "freq_no_step": (primary(CDELT4=None),
        "primary HDU: CDELT4: keyword is missing"),
    "if_without_table": (primary(CTYPE5="IF", NAXIS5=2, GCOUNT=1),
        "primary HDU: NAXIS5: there are 2 IFs but no AIPS FQ table with their frequencies; "
        "the file may be truncated"),
    "dec_no_value": (primary(CRVAL6=None),
        "primary HDU: CRVAL6: no phase centre: neither an axis value nor OBSDEC"),
    "dec_beyond_pole": (primary(CRVAL6=91.0),
        "primary HDU: CRVAL6: declination 91 deg"),
    "axis_twice": (primary(CTYPE3="FREQ"),
        "primary HDU: CTYPE4: there is a second axis 'FREQ'"),
    # Parameters.
    "pscal_nan": (primary(PSCAL1=Raw("nan")),
        "primary HDU: PSCAL1: must be a number, found 'nan'"),
    "pzero_overflow": (primary(PZERO4=Raw("1E999")),
        "primary HDU: PZERO4: must be a number, found '1E999'"),
    "uu_missing": (primary(PTYPE1="XX"),
        "primary HDU: PTYPE: no random parameter is called UU"),
    "uu_unknown": (primary(PTYPE1="UU---TAN"),
        "primary HDU: PTYPE1: coordinate type 'UU---TAN' is not known"),
    "date_missing": (primary(PTYPE4="TIME"),
        "primary HDU: PTYPE: no random parameter is called DATE"),
    "baseline_missing": (primary(PTYPE5="BL"),
        "primary HDU: PTYPE: no random parameter is called BASELINE, nor ANTENNA1 and ANTENNA2"),
    # Groups.
    "uu_nan": (replaced(2, UU=float("nan")),
        "primary HDU: group 2 of 3: UU: NaN is not finite"),
    "date_infinite": (replaced(3, DATE=float("inf")),
        "primary HDU: group 3 of 3: DATE: NaN is not finite"),
    "baseline_nan": (replaced(2, BASELINE=float("nan")),
        "primary HDU: group 2 of 3: BASELINE: NaN is no pair of antennas"),
    "baseline_negative": (replaced(2, BASELINE=-258.0),
        "primary HDU: group 2 of 3: BASELINE: -258 is no pair of antennas"),
    "antenna_unknown": (replaced(2, BASELINE=260.0),
        "primary HDU: group 2 of 3: BASELINE: antenna 4 of subarray 1 is not in the AIPS AN table"),
    "antenna_fraction": (lambda p, t: p.set(PTYPE5="ANTENNA1", PTYPE6="ANTENNA2", PZERO5=-257.5),
        "primary HDU: group 1 of 3: ANTENNA1: 0.5 is not a whole number of 0 or more"),
    "freqsel_unknown": (primary(PTYPE6="FREQSEL"),
        "primary HDU: group 1 of 3: FREQSEL: 8 is not in its table"),
    # The antenna table.
    "antennas_renamed": (antennas(EXTNAME="AIPS XX"),
        "file: AIPS AN: there is no antenna table; the file may be truncated"),
    "antennas_as_image": (antennas(XTENSION="IMAGE"),
        "HDU 1 (AIPS AN): XTENSION: must be a BINTABLE"),
    "antennas_no_numbers": (antennas(TTYPE3="NUMBER"),
        "HDU 1 (AIPS AN): NOSTA: column is missing"),
    "antennas_short_position": (antennas(TFORM2="2D", NAXIS1=28),
        "HDU 1 (AIPS AN): STABXYZ: column has 2 elements a row, needs 3"),
    "antennas_text_position": (antennas(TFORM2="24A"),
        "HDU 1 (AIPS AN): STABXYZ: column 2 holds type A, not numbers"),
    "antennas_row_lies": (antennas(NAXIS1=12),
        "HDU 1 (AIPS AN): NAXIS1: is 12, but the columns add up to 36 bytes a row"),
    "antennas_rows_lie": (antennas(NAXIS2=2**40),
        "HDU 1 (AIPS AN): data: the header announces 39582418599936 bytes of data (padded to "
        "blocks of 2880), the file has 2880 left: it is truncated or the header is wrong"),
    "antennas_format_wrong": (antennas(TFORM2="3Z"),
        "HDU 1 (AIPS AN): TFORM2: '3Z' is no format of a table column"),
    "antennas_format_overflow": (antennas(TFORM2="18446744073709551615D"),
        "HDU 1 (AIPS AN): TFORM2: '18446744073709551615D' is no format of a table column"),
    "antennas_fields_lie": (antennas(TFIELDS=500),
        "HDU 1 (AIPS AN): TFORM4: keyword is missing"),
    "antennas_fields_huge": (antennas(TFIELDS=2**40),
        "HDU 1 (AIPS AN): TFIELDS: is 1099511627776, at most 999 can be"),
    "antennas_twice": (lambda p, t: setattr(t, "data", t.data[:36] + t.data[:36] + t.data[72:]),
        "file: AIPS AN: NOSTA: antenna 1 of subarray 1 stands there twice"),
    "antennas_position_nan": (lambda p, t: setattr(
        t, "data", t.data[:8] + struct.pack(">d", float("nan")) + t.data[16:]),
        "HDU 1 (AIPS AN): STABXYZ: row 1: the position is not finite"),
}


def make(change):
    if isinstance(change, bytes):
        return change
    hdus = good()
    if isinstance(change, int):
        return b"".join(hdu.bytes() for hdu in hdus)[:change]
    change(*hdus)
    return b"".join(hdu.bytes() for hdu in hdus)


def main():
    folder = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "fixtures" / "bad"
    folder.mkdir(parents=True, exist_ok=True)
    for name, (change, message) in CASES.items():
        (folder / f"{name}.uvfits").write_bytes(make(change))
        (folder / f"{name}.uvfits.txt").write_text(message + "\n")


if __name__ == "__main__":
    main()
