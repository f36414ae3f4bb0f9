#!/usr/bin/env python3
"""Runs experiments of Malyali et al. (2018), and ours, each from its file in `cases`.

    run.py sparse-20            one of them; the result goes to results/sparse-20.json
    run.py --list               what there is
    run.py faint dense --keep FOLDER --threads 1

A case says what is simulated and how it is searched, as options of vis2cat, and what the paper has; `kind` says which
module of this folder measures it (`fields` if it says nothing). `docs/paper.md` is written from the results by
`tables.py`. Needs numpy, astropy,
scipy, GNU time and a release build.
"""

import argparse
import importlib
import json
import pathlib
import platform
import subprocess
import sys
import tempfile
import tomllib

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
sys.path.insert(0, str(HERE.parent))


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("cases", nargs="*", metavar="CASE", help="name of a file in cases")
    parser.add_argument("--list", action="store_true", help="print the cases and their titles")
    parser.add_argument("--program", type=pathlib.Path, default=ROOT / "target/release/vis2cat")
    parser.add_argument("--keep", type=pathlib.Path, help="folder for catalogues, and for fields to use again")
    parser.add_argument("--threads", type=int, help="of each search [default: all cores]")
    parser.add_argument("--results", type=pathlib.Path, default=HERE / "results", help="folder for the results")
    return parser.parse_args()


def load(name):
    path = HERE / "cases" / f"{name}.toml"
    if not path.exists():
        sys.exit(f"there is no {path}; --list prints what there is")
    return tomllib.loads(path.read_text())


def processor():
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.processor()


def commit():
    """The commit that is checked out; the program is taken to be built from it."""
    done = subprocess.run(["git", "describe", "--always"], cwd=ROOT, capture_output=True, text=True)
    return done.stdout.strip()


def main():
    args = arguments()
    if args.list or not args.cases:
        for path in sorted((HERE / "cases").glob("*.toml")):
            print(f"{path.stem:>14}  {load(path.stem)['title']}")
        return
    for name in args.cases:
        case = load(name)
        module = importlib.import_module(case.get("kind", "fields"))
        with tempfile.TemporaryDirectory() as scratch:
            folder = (args.keep or pathlib.Path(scratch)) / name
            folder.mkdir(parents=True, exist_ok=True)
            result = module.run(case, args, folder)
        result = {"case": case, "commit": commit(), "processor": processor(), "threads": args.threads} | result
        args.results.mkdir(exist_ok=True)
        (args.results / f"{name}.json").write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
