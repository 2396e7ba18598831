"""Prints what .ci/audit needs of a checkout of the RustSec database (the first argument) for the
crates named on standard input: ranges of versions that an advisory concerns, without those that
only inform ("notice")."""

import re
import subprocess
import sys
import textwrap
import tomllib
from pathlib import Path


def version(text):
    parts = [int(n) for n in re.match(r"\d+(\.\d+)*", text.strip()).group().split(".")]
    return tuple(parts + [0] * (3 - len(parts)))


def span(requirement):
    """Returns the first version a requirement admits, and the first after it that it does not."""
    first, last = (0, 0, 0), None
    for part in requirement.split(","):
        sign, number = re.match(r"\s*(>=|<=|>|<|=|\^|~)?\s*(.+)", part).groups()
        v = version(number)
        after = v[:2] + (v[2] + 1,)
        if sign in (">=", "^", "~", None, "="):
            first = v
        if sign == ">":
            first = after
        if sign == "<":
            last = v
        if sign in ("<=", "="):
            last = after
        if sign in ("^", None):
            last = (v[0] + 1, 0, 0) if v[0] else (0, v[1] + 1, 0)
        if sign == "~":
            last = (v[0], v[1] + 1, 0)
    return first, last


def affected(versions):
    """Returns the ranges that neither `patched` nor `unaffected` covers."""
    good = sorted(span(r) for r in versions.get("patched", []) + versions.get("unaffected", []))
    at, ranges = (0, 0, 0), []
    for first, last in good:
        if first > at:
            ranges.append((at, first))
        if last is None:
            return ranges
        at = max(at, last)
    return ranges + [(at, None)]


def main():
    base = Path(sys.argv[1])
    names = [n for n in sys.stdin.read().split() if n not in ("harmolux", "harmolux-fuzz")]
    day = subprocess.check_output(["git", "-C", base, "log", "-1", "--format=%cs"], text=True)
    print(f"# Of the RustSec database as of {day.strip()}, made by `.ci/audit --renew`.")
    for line in textwrap.wrap(" ".join(names), 94, break_on_hyphens=False):
        print("known", line)
    for name in names:
        for path in sorted((base / "crates" / name).glob("RUSTSEC-*.md")):
            text = path.read_text(encoding="utf-8")
            facts = tomllib.loads(re.search(r"```toml\n(.*?)```", text, re.S).group(1))
            advisory = facts["advisory"]
            if advisory.get("withdrawn") or advisory.get("informational") == "notice":
                continue
            for first, last in affected(facts["versions"]):
                dotted = [".".join(map(str, v)) if v else "any" for v in (first, last)]
                print("affected", name, advisory["id"], *dotted)


main()
