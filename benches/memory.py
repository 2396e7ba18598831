#!/usr/bin/env python3
"""Runs every verb of harmolux on large inputs within limits of memory, and counts how it ends.

    benches/memory.py [HARMOLUX] [--way as|data|flag] [--megabytes 50,100,...] [--show]

A run may end with what was asked for, or with a message and an exit code: never by a signal or a
panic. The ways to limit: `as` is `ulimit -v`, `data` is `ulimit -d`, `flag` is `--max-memory`.
"""

import collections
import os
import resource
import subprocess
import sys
import tempfile

from common import CAMERA, ROOM, body, grid, parser, put

ENVIRONMENT = {**os.environ, "RUST_BACKTRACE": "0"}
LIMITS = "50,64,80,100,150,200,300,500,700,1000,2000,4000"
STOPS = """resolution = [16, 16]
[render]
stop = { time = "1s" }
[illum]
stop = { time = "1s" }
"""
VERBS = """\
render room.toml --size 4096x4096 -o a.png --force
render room.toml -o a.exr --force
render head.toml -o a.exr --force
illum grid.toml -o a.csv --force
probe room.toml --quick
exact sobolev
falsecolor large.exr -o a.png --force
check ball.ply
check ball.ply --repair -o a.obj --force
fit ball.ply -l 100 -o a.txt --force
fit ball.ply -l 16 -o b.txt --force
info high.txt
info ball.ply
convert high.txt a.bshc --force
convert ball.ply a.obj --force
sweep ball.ply -l 4,64 -o out --force
spectrum high.txt -o a.svg --force
diff ball.ply high.txt
mesh high.txt -o a.ply --resolution 300 --force
transform high.txt --euler 10,20,30 -o a.txt --force
mean high.txt high.txt -o a.txt --force
random --power-law rms=0.05,exponent=4 -l 1000 -o a.txt --force
"""


def run(tool, folder, words, way, megabytes):
    """Returns how a run ended, and what it said."""
    size = megabytes << 20
    kind = {"as": resource.RLIMIT_AS, "data": resource.RLIMIT_DATA}.get(way)
    bound = (lambda: resource.setrlimit(kind, (size, size))) if kind else None
    flag = [] if kind else ["--max-memory", f"{megabytes}M"]
    try:
        done = subprocess.run(
            [tool, *words, *flag],
            cwd=folder,
            preexec_fn=bound,
            timeout=300,
            env=ENVIRONMENT,
            capture_output=True,
            input=b"1 1 1 0 0 1\n" * 500_000 if words[0] == "probe" else b"",
        )
    except subprocess.TimeoutExpired:
        return "time out", ""
    said = done.stderr.decode(errors="replace")
    if "panicked" in said:
        return "panic", said
    if done.returncode < 0:
        return f"signal {-done.returncode}", said
    if done.returncode and not said.strip():
        return "silent", said
    if "memory allocation of" in said:
        return "exit 1 (net)", said
    return f"exit {done.returncode}", said


def main():
    arguments = parser(__doc__)
    arguments.add_argument("--way", default="as", choices=["as", "data", "flag"])
    arguments.add_argument("--megabytes", default=LIMITS)
    arguments.add_argument("--resolution", default=180, type=int, help="of the mesh: 20 N^2 faces")
    arguments.add_argument("--degree", default=200, type=int, help="of the shape")
    arguments.add_argument("--show", action="store_true", help="the last line that each run said")
    asked = arguments.parse_args()
    limits = [int(number) for number in asked.megabytes.split(",")]
    total = collections.Counter()
    with tempfile.TemporaryDirectory() as folder:
        room = ROOM + CAMERA + STOPS
        head = room + body("high.txt", asked.degree)
        put(folder, {"room.toml": room, "grid.toml": room + grid(1000), "head.toml": head})
        start = lambda words: subprocess.run(
            [asked.tool, *words.split()], cwd=folder, capture_output=True
        )
        start(f"random --power-law rms=0.05,exponent=4 -l {asked.degree} -o high.txt")
        start(f"mesh high.txt -o ball.ply --resolution {asked.resolution}")
        start("render room.toml --size 400x300 -D render.stop.time=20s -o large.exr")
        print("| run |", " | ".join(f"{limit} MB" for limit in limits), "|")
        print("|:---|" + "---:|" * len(limits))
        for verb in VERBS.splitlines():
            ends = [run(asked.tool, folder, verb.split(), asked.way, limit) for limit in limits]
            print(f"| {verb} |", " | ".join(end for end, _ in ends), "|", flush=True)
            total.update(end for end, _ in ends)
            for limit, (end, said) in zip(limits, ends) if asked.show else ():
                print(f"    {limit} MB, {end}: {(said.strip().splitlines() or [''])[-1][:200]}")
    print("\n" + ", ".join(f"{count} {end}" for end, count in sorted(total.items())))
    return any(end.split()[0] in ("panic", "signal", "silent", "time") for end in total)


if __name__ == "__main__":
    sys.exit(main())
