#!/usr/bin/env python3
"""Writes the tables of docs/paper.md from what run.py measured.

    tables.py          every block between <!-- NAME --> and <!-- end --> becomes the table of results/NAME.json

Needs nothing but Python.
"""

import json
import pathlib
import re

HERE = pathlib.Path(__file__).resolve().parent
PAGE = HERE.parent.parent / "docs" / "paper.md"


def table(head, rows):
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines)


def fields(result):
    """Tables of the seeds, of cuts moved over the modes if any galaxy was missed or false, and of pulls."""
    seeds = result["seeds"]
    head = ["seed", "visibilities", "found", "missed", "false", "ln L", "CPU [s]", "memory [MB]"]
    rows = [[s["seed"], s["n_sample"], s["found"], s["missed"], s["false"], f"{s['n_eval'] / 1e6:.2f} million",
             f"{s['cpu_seconds']:.0f}", f"{s['megabytes']:.0f}"] for s in seeds]
    parts = [table(head, rows)]
    if any("clean" in s for s in seeds) and any(s["false"] or s["missed"] for s in seeds):
        parts.append(cuts(seeds))
    if result["parameters"]:
        parts.append(pulls(result["parameters"]))
    return "\n\n".join(parts)


def cuts(seeds):
    head = ["seed", "area under the ROC curve, by SNR", "by ln Z", "lowest cut without a false one", "true above it",
            "of those with SNR 5 or more", "oracle at the same cut"]
    rows = []
    for s in seeds:
        clean = s.get("clean")
        area = lambda key: "–" if s.get(key) is None else f"{s[key]:.3f}"
        row = [s["seed"], area("roc_area"), area("log_z_roc_area")]
        if clean:
            of = clean["completeness_snr_5"]
            oracle = clean.get("oracle_snr_5")
            row += [f"{clean['cut']:.2f}", clean["n_true"], f"{of[0]} of {of[1]}",
                    f"{oracle[0]} of {oracle[1]}" if oracle else "–"]
        rows.append(row + ["–"] * (len(head) - len(row)))
    known = [s for s in seeds if s.get("roc_area") is not None and s.get("clean")]
    if len(known) > 1:
        mean = lambda values: f"{sum(values) / len(known):.3f}"
        part = lambda key: mean([s["clean"][key][0] / s["clean"][key][1] for s in known])
        rows.append(["mean", mean([s["roc_area"] for s in known]), mean([s["log_z_roc_area"] for s in known]), "", "",
                     part("completeness_snr_5"), part("oracle_snr_5") if "oracle_snr_5" in known[0]["clean"] else "–"])
    return table(head, rows)


def pulls(parameters):
    head = ["pulls of", "galaxies", "mean", "rms", "largest", "in 68%", "in 95%", "SNR ≥ 10: beyond 5 sigma"]
    part = lambda p, level: f"{p[level][0] / p[level][1]:.3f}" if p.get(level) and p[level][1] else "–"
    rows = [[p["name"].replace("_", " ").lower(), p["n"], f"{p['mean']:.2f} ± {p['mean_err']:.2f}", f"{p['rms']:.2f}",
             f"{p['largest']:.1f}", part(p, "in_68"), part(p, "in_95"),
             f"{p['beyond_5_snr_10']} of {p['n_snr_10']}"] for p in parameters]
    return table(head, rows)


def live_points(result):
    rows = result["rows"]
    cut = list(rows[0]["modes_above"])
    head = ["galaxies", "live points", "found", "false", "ln L", "CPU [s]", *(f"modes ≥ {c} µJy" for c in cut)]
    return table(head, [[r["n_source"], r["n_live"], r["found"], r["false"], f"{r['n_eval'] / 1e6:.2f} million",
                         f"{r['cpu_seconds']:.0f}", *(r["modes_above"][c] for c in cut)] for r in rows])


def calibration(result):
    head = ["parameter", "p of uniform ranks", "in 50%", "in 68%", "in 95%"]
    rows = [[p["name"].replace("_", " ").lower(), f"{p['p_value']:.3f}",
             *(f"{p['covered'][level] / p['n']:.3f}" for level in ("0.50", "0.68", "0.95"))]
            for p in result["parameters"]]
    left = len(result["not_one_row"])
    return f"{result['n_source']} galaxies; {left} more had not exactly one row.\n\n" + table(head, rows)


def blends(result):
    head = ["blend", "all found", "sampled jointly", "rms pull", "largest", "chi²", "parameters"]
    return table(head, [[r["name"], f"{r['all_found']} of {r['blends']}", r["sampled_jointly"], f"{r['rms_pull']:.2f}",
                         f"{r['largest_pull']:.1f}", f"{r['chi2']:.1f}" + (f" ± {r['chi2_err']:.1f}" if r["all_found"] > 1 else ""), r["parameters"]]
                        for r in result["rows"]])


KINDS = {"fields": fields, "live_points": live_points, "calibration": calibration, "blends": blends}


def block(name):
    path = HERE / "results" / f"{name}.json"
    if not path.exists():
        return "(not run yet)"
    result = json.loads(path.read_text())
    case = result["case"]
    options = [f"simulate {case['simulate']}" if "simulate" in case else "", f"search {case.get('search', '')}"]
    made = f"`{'`, `'.join(option.strip() for option in options if option.strip() not in ('', 'search'))}`; " \
        if "simulate" in case else ""
    threads = f"{result['threads']} thread" if result["threads"] == 1 else "all cores"
    return f"{KINDS[case.get('kind', 'fields')](result)}\n\n{made}{result['commit']}, {result['processor']}, {threads}."


def main():
    page = PAGE.read_text()
    fill = lambda match: f"<!-- {match[1]} -->\n{block(match[1])}\n<!-- end -->"
    PAGE.write_text(re.sub(r"<!-- ([a-z0-9-]+) -->\n.*?<!-- end -->", fill, page, flags=re.S))


if __name__ == "__main__":
    main()
