#!/usr/bin/env python3
"""Measures how soon a run ends when it is asked to, and how soon it first says what it is at.

    cargo build --release
    python3 benches/cancel.py [HARMOLUX] [--quick]

HARMOLUX is target/release/harmolux unless it is named. For each case and moment (seconds after the
start) a run gets SIGINT once. Columns: when its first line came on stderr (- when it was
interrupted before), the seconds from the signal to its end, the exit code, and the bytes that it
left. Runs that hold results in memory save them before they end; the seconds of that are in the
table. `--quick` takes sizes a tenth as large each way. Needs nothing but Python.
"""

import shutil
import signal
import subprocess
import tempfile
import threading
import time
from pathlib import Path

from common import CAMERA, ROOM, SENSOR, body, grid, parser, put

HEAD = Path(__file__).resolve().parent.parent / "data/head.obj"
HEADS = [f"head{i}.obj" for i in range(50)]


def fill(folder, side, pixels, degree):
    """Puts the scenes and the meshes into a folder."""
    picture = f"resolution = [{pixels}, {pixels}]\n[render]\nstop = {{ walks = 1000000 }}\n"
    put(
        folder,
        {
            "sensors.toml": ROOM + grid(side) + "[illum]\nstop = { walks = 1000000000 }\n",
            "picture.toml": ROOM + CAMERA + picture,
            "body.toml": ROOM + body("head0.obj", degree) + SENSOR,
        },
    )
    for name in HEADS:
        shutil.copy(HEAD, folder / name)


def cases(side, pixels, degree, fitted):
    """Lists each case: its name, the words of the command, and the moments."""
    render = ["render", "picture.toml", "-o", "out.exr"]
    fit = ["fit", "head0.obj", "-l", str(fitted), "-o", "out.txt"]
    sweep = ["sweep", "head0.obj", "-l", "2..100", "-o", "out"]
    yield f"illum, {side}^2 sensors", ["illum", "sensors.toml", "-o", "out.csv"], [0.5, 3, 10, 60]
    yield f"render, {pixels}^2 pixels", render, [0.5, 3, 10, 60, 180]
    yield f"start-up, SH of degree {degree}", ["illum", "body.toml"], [0.5, 3, 10]
    yield f"fit, degree {fitted}", fit, [0.5, 3, 6]
    yield "sweep, degree 2 to 100", sweep, [0.5, 3, 10]
    yield "fit of 50 meshes", ["fit", *HEADS, "-l", "32", "-o", "out"], [0.5, 2]


def clear(folder):
    """Removes what a run left."""
    for path in folder.glob("out*"):
        shutil.rmtree(path) if path.is_dir() else path.unlink()


def left(folder):
    """Returns the bytes that a run left."""
    found = [path for top in folder.glob("out*") for path in (top, *top.rglob("*"))]
    return sum(path.stat().st_size for path in found if path.is_file())


def cancelled(command, folder, after):
    """Returns when the first line came, the seconds from the signal to the end, the exit code."""
    clear(folder)
    run = subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    started, lines = time.monotonic(), []

    def listen():
        for _ in run.stderr:
            lines.append(time.monotonic() - started)

    listener = threading.Thread(target=listen)
    listener.start()
    time.sleep(after)
    asked = time.monotonic()
    run.send_signal(signal.SIGINT)
    code = run.wait()
    seconds = time.monotonic() - asked
    listener.join()
    first = lines[0] if lines and lines[0] < after else None
    return first, seconds, code


def main():
    arguments = parser(__doc__)
    arguments.add_argument("--quick", action="store_true", help="sizes a tenth as large each way")
    given = arguments.parse_args()
    # Runs inherit what is ignored, as where this runs in a script's background job.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    side, pixels, degree, fitted = (100, 410, 60, 64) if given.quick else (1000, 4096, 300, 200)
    print("case                              moment  first line  end after  code    left, bytes")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        fill(folder, side, pixels, degree)
        for case, words, moments in cases(side, pixels, degree, fitted):
            for moment in moments:
                first, seconds, code = cancelled([given.tool, *words], folder, moment)
                said = "-" if first is None else f"{first:.1f} s"
                row = f"{case:<32}{moment:>6} s{said:>12}{seconds:>9.2f} s{code:>6}"
                print(f"{row}{left(folder):>15}", flush=True)


if __name__ == "__main__":
    main()
