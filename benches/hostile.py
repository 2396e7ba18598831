#!/usr/bin/env python3
"""Makes small inputs that took the tool a long time once, and times it on each.

    python3 benches/hostile.py [HARMOLUX] [--limit SECONDS]

HARMOLUX is target/release/harmolux unless it is named. Of each input: the seconds it took (`>` when
it was ended at the limit) and those of all processors, the exit code, and the first line of what
was said.
"""

import os
import random
import subprocess
import tempfile
import time

from common import ROOM, SENSOR, body, parser, put

MANY = 2_000_000
STOP = "[illum]\nstop = { walks = 256 }\n"

PLY = """ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
element face 1
property list uint int vertex_indices
{}end_header
0 0 0
1 0 0
0 1 0
{}
"""


def cube(size):
    """Returns a cube as OFF."""
    corners = [
        f"{x * size} {y * size} {z * size}\n" for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)
    ]
    sides = ["0 2 3 1", "4 5 7 6", "0 1 5 4", "2 6 7 3", "0 4 6 2", "1 3 7 5"]
    return "OFF\n8 6 0\n" + "".join(corners) + "".join(f"4 {side}\n" for side in sides)


def series(degree, size, wave):
    """Returns coefficients as text: a mean radius, and `wave` of degree and order for the
    others."""
    head = "# harmolux 0.1.0 coefficients\n# normalisation: 4pi\n# csphase: 1\n# unit: m\n"
    rows = [f"# centre: 0.0 0.0 0.0\n# lmax: {degree}\n0, 0, {size!r}, 0.0\n"]
    for l in range(1, degree + 1):
        for m in range(l + 1):
            rows.append(f"{l}, {m}, {size * wave(l)!r}, {size * wave(l) if m else 0.0!r}\n")
    return head + "".join(rows)


def inputs():
    """Lists each case: its name, its files by name, and the words of the command."""
    numbers = " ".join(["0"] * MANY)
    cycle = " ".join(str(i % 3) for i in range(200))
    layers = f"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n200 {cycle}\n"
    elements = "".join(f"element e{i} 0\n" for i in range(100_000))
    noise = random.Random(1)
    flat = series(300, 1.0, lambda l: noise.uniform(-1, 1))
    smooth = lambda l: 0.05 / (l + 1) ** 2
    scene = lambda *shape: {
        "body.txt": series(16, 0.5, smooth),
        "scene.toml": ROOM + body("body.txt", *shape) + SENSOR + STOP,
    }
    named = scene(16, "", "a" * 99_999 + "b")
    named["scene.toml"] = named["scene.toml"].replace("grey", "a" * 100_000)
    march = 'intersector = "step-bisection"\nstep = 1e-12\n'
    illum = ["illum", "scene.toml"]
    yield "coincident layers", {"a.off": layers}, ["check", "a.off"]
    yield "two long names", named, illum
    for name in ["a.xyz", "a.csv"]:
        yield f"a long line, {name[1:]}", {name: numbers}, ["fit", name, "-l", "4", "-o", "out.txt"]
    for name in ["a.txt", "a.dov", "a.coef", "a.tab"]:
        yield f"a long line, {name[1:]}", {name: numbers}, ["info", name]
    yield "a long line, .obj", {"a.obj": f"v {numbers}\nf 1 1 1\n"}, ["info", "a.obj"]
    yield "a long line, .ply", {"a.ply": PLY.format("", f"{MANY} {numbers}")}, ["info", "a.ply"]
    yield "many elements", {"a.ply": PLY.format(elements, "3 0 1 2")}, ["info", "a.ply"]
    yield "flat spectrum to .hxc", {"a.txt": flat}, ["convert", "a.txt", "a.hxc"]
    for size in [1e-100, 1e150]:
        for verb in [["check"], ["fit", "-l", "8", "-o", "out.txt"], ["diff", "a.off"]]:
            yield f"{verb[0]}, {size:g} m", {"a.off": cube(size)}, [verb[0], "a.off", *verb[1:]]
        shape = {"a.txt": series(4, size, smooth)}
        yield f"mesh, {size:g} m", shape, ["mesh", "a.txt", "-o", "a.ply"]
        yield f"diff of shapes, {size:g} m", shape, ["diff", "a.txt", "a.txt"]
    yield "degree 16", scene(16), illum
    yield "degree 1400 of a file of 16", scene(1400), illum
    yield "step 1e-12", scene(16, march), illum


def run(tool, files, words, limit):
    """Runs one case in a folder of its own; gives both times, the exit code and what was said."""
    with tempfile.TemporaryDirectory() as folder:
        put(folder, files)
        start, used = time.monotonic(), os.times().children_user
        try:
            done = subprocess.run([tool, *words], cwd=folder, capture_output=True, timeout=limit)
        except subprocess.TimeoutExpired:
            return f"> {limit:g}", os.times().children_user - used, "", ""
        took, used = time.monotonic() - start, os.times().children_user - used
        said = (done.stderr + done.stdout).decode(errors="replace")
        return f"{took:.2f}", used, done.returncode, said.split("\n")[0][:70]


def main():
    arguments = parser(__doc__)
    arguments.add_argument("--limit", type=float, default=60, help="seconds")
    given = arguments.parse_args()
    for name, files, words in inputs():
        took, used, code, said = run(given.tool, files, words, given.limit)
        print(f"{name:28} {took:>7} s {used:>7.2f} s  {code!s:2} {said}", flush=True)


if __name__ == "__main__":
    main()
