"""How soon a run ends when it is asked to, and how soon it first says what it is at.

    cargo build --release
    python3 benches/cancel.py target/release/harmolux [--quick]

For each case and moment (seconds after the start) a run gets SIGINT once. Columns: when its first line came on stderr (- when it was interrupted before), the seconds from the signal to its end, the
exit code, and the bytes that it left. Runs that hold results in memory save them before they end; the seconds of that are in the table. `--quick` takes sizes a tenth as large each way. Needs nothing
but Python.
"""
import json, os, shutil, signal, subprocess, sys, tempfile, threading, time

if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
    sys.exit(__doc__)
TOOL, QUICK = os.path.abspath(sys.argv[1]), "--quick" in sys.argv
HEAD = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../data/head.obj")
SIDE, PIXELS, DEGREE, FIT = (100, 410, 60, 64) if QUICK else (1000, 4096, 300, 200)
ROOM = """format = 1
[materials.grey.lambert]
reflectance = 0.5
[objects.room.box]
min = [0, 0, 0]
max = [8, 6, 3]
inward = true
material = "grey"
[lights.lamp.point]
at = [4, 3, 2.9]
intensity = 1000
"""
SENSORS = f'[sensors.floor.grid]\non = "room.z_min"\ncount = [{SIDE}, {SIDE}]\n[illum]\nstop = {{ walks = 1000000000 }}\n'
CAMERA = f"[cameras.main.perspective]\nfrom = [1, 1, 1.5]\nto = [4, 3, 1]\nfov = 60\nresolution = [{PIXELS}, {PIXELS}]\n[render]\nstop = {{ walks = 1000000 }}\n"
BODY = f'[objects.head.sh]\nfile = {json.dumps(os.path.abspath(HEAD))}\ndegree = {DEGREE}\nat = [4, 3, 1]\nmaterial = "grey"\n'

folder = tempfile.TemporaryDirectory()


def put(name, text):
    with open(os.path.join(folder.name, name), "w") as file:
        file.write(text)


put("sensors.toml", ROOM + SENSORS)
put("picture.toml", ROOM + CAMERA)
put("body.toml", ROOM + BODY + "[sensors.one.points]\nat = [[1, 1, 0]]\nnormal = [0, 0, 1]\n")
for i in range(50):
    shutil.copy(HEAD, os.path.join(folder.name, f"head{i}.obj"))
heads = [f"head{i}.obj" for i in range(50)]
CASES = [
    (f"illum, {SIDE}^2 sensors", ["illum", "sensors.toml", "-o", "out.csv"], [0.5, 3, 10, 60]),
    (f"render, {PIXELS}^2 pixels", ["render", "picture.toml", "-o", "out.exr"], [0.5, 3, 10, 60, 180]),
    (f"start-up, SH of degree {DEGREE}", ["illum", "body.toml"], [0.5, 3, 10]),
    (f"fit, degree {FIT}", ["fit", "head0.obj", "-l", str(FIT), "-o", "out.txt"], [0.5, 3, 6]),
    ("sweep, degree 2 to 100", ["sweep", "head0.obj", "-l", "2..100", "-o", "out"], [0.5, 3, 10]),
    ("fit of 50 meshes", ["fit", *heads, "-l", "32", "-o", "out"], [0.5, 2]),
]


def clear():
    for name in os.listdir(folder.name):
        if name.startswith("out"):
            path = os.path.join(folder.name, name)
            shutil.rmtree(path) if os.path.isdir(path) else os.remove(path)


def left():
    paths = (os.path.join(at, name) for at, _, names in os.walk(folder.name) for name in names)
    return sum(os.path.getsize(p) for p in paths if os.path.relpath(p, folder.name).startswith("out"))


def cancelled(command, after):
    """When the first line came, the seconds from the signal to the end, and the exit code."""
    clear()
    run = subprocess.Popen([TOOL, *command], cwd=folder.name, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
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


print(f"{'case':<32}{'moment':>8}{'first line':>12}{'end after':>11}{'code':>6}{'left, bytes':>15}")
for name, command, moments in CASES:
    for moment in moments:
        first, seconds, code = cancelled(command, moment)
        said = "-" if first is None else f"{first:.1f} s"
        print(f"{name:<32}{moment:>6} s{said:>12}{seconds:>9.2f} s{code:>6}{left():>15}", flush=True)
