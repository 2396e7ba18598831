#!/usr/bin/env python3
"""Makes small inputs that took the tool a long time once, and times it on each.

    python3 benches/hostile.py [HARMOLUX] [--limit SECONDS]

HARMOLUX is target/release/harmolux unless it is named. Of each input: the seconds it took (`>` when
it was ended at the limit) and those of all processors, the exit code, and the first line of what
was said.
"""

import argparse
import os
import random
import subprocess
import tempfile
import time
from pathlib import Path

MANY = 2_000_000

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

SCENE = """format = 1
[materials.grey.lambert]
reflectance = 0.5
[objects.room.box]
min = [0, 0, 0]
max = [4, 4, 4]
inward = true
material = "grey"
[objects.body.sh]
file = "body.txt"
{}at = [2, 2, 2]
material = "{}"
[lights.lamp.point]
at = [0.5, 0.5, 3.5]
intensity = 100
[sensors.floor.points]
at = [[1, 1, 0]]
normal = [0, 0, 1]
[illum]
stop = {{ walks = 256 }}
"""


def cube(size):
    """Returns a cube as OFF."""
    corners = [f"{x * size} {y * size} {z * size}\n" for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
    sides = ["0 2 3 1", "4 5 7 6", "0 1 5 4", "2 6 7 3", "0 4 6 2", "1 3 7 5"]
    return "OFF\n8 6 0\n" + "".join(corners) + "".join(f"4 {side}\n" for side in sides)


def body(degree, size, wave):
    """Returns coefficients as text: a mean radius, and `wave` of degree and order for the others."""
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
    flat = body(300, 1.0, lambda l: noise.uniform(-1, 1))
    smooth = lambda l: 0.05 / (l + 1) ** 2
    scene = lambda keys, material="grey": {
        "body.txt": body(16, 0.5, smooth),
        "scene.toml": SCENE.format(keys, material),
    }
    named = scene("degree = 16\n", "a" * 99_999 + "b")
    named["scene.toml"] = named["scene.toml"].replace("grey", "a" * 100_000)
    march = 'degree = 16\nintersector = "step-bisection"\nstep = 1e-12\n'
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
        shape = {"a.txt": body(4, size, smooth)}
        yield f"mesh, {size:g} m", shape, ["mesh", "a.txt", "-o", "a.ply"]
        yield f"diff of shapes, {size:g} m", shape, ["diff", "a.txt", "a.txt"]
    yield "degree 16", scene("degree = 16\n"), illum
    yield "degree 1400 of a file of 16", scene("degree = 1400\n"), illum
    yield "step 1e-12", scene(march), illum


def run(tool, files, words, limit):
    """Runs one case in a folder of its own; gives both times, the exit code and what was said."""
    with tempfile.TemporaryDirectory() as folder:
        for name, text in files.items():
            Path(folder, name).write_text(text)
        start, used = time.monotonic(), os.times().children_user
        try:
            done = subprocess.run([tool, *words], cwd=folder, capture_output=True, timeout=limit)
        except subprocess.TimeoutExpired:
            return f"> {limit:g}", os.times().children_user - used, "", ""
        took, used = time.monotonic() - start, os.times().children_user - used
        said = (done.stderr + done.stdout).decode(errors="replace")
        return f"{took:.2f}", used, done.returncode, said.split("\n")[0][:70]


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("tool", nargs="?", default="target/release/harmolux")
    arguments.add_argument("--limit", type=float, default=60, help="seconds")
    given = arguments.parse_args()
    tool = str(Path(given.tool).resolve())
    for name, files, words in inputs():
        took, used, code, said = run(tool, files, words, given.limit)
        print(f"{name:28} {took:>7} s {used:>7.2f} s  {code!s:2} {said}", flush=True)


if __name__ == "__main__":
    main()
