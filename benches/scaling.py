"""What illuminance costs: time against points, walks, objects and threads, with fitted exponents,
and the memory of a million points.

    cargo build --release
    python3 benches/scaling.py target/release/harmolux [--quick]

One thread, except in the table of threads. Times are the `seconds` of the JSON, the median of three
runs, the sizes of a table in turns; CPU times are those of the whole process, and memory is its
largest resident size. Needs nothing but Python. The room is that of data/scenes/workplane.toml; in
the table of objects it holds a cubic lattice of heads of degree 32 that share one surface.
"""

import json, math, os, statistics, subprocess, sys, tempfile

if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
    sys.exit(__doc__)
TOOL, QUICK = sys.argv[1], "--quick" in sys.argv
HERE = os.path.dirname(os.path.abspath(__file__))
HEAD = os.path.join(HERE, "../data/head.obj")
with open(os.path.join(HERE, "../data/scenes/workplane.toml")) as file:
    ROOM = file.read().split("[sensors.")[0]
TURNS = 1 if QUICK else 3
folder = tempfile.TemporaryDirectory()


def grid(columns, rows):
    return f"[sensors.plane.grid]\nheight = 0.8\ncount = [{columns}, {rows}]\n"


def heads(count):
    """Heads on a lattice in the room, clear of the lamp and of each other."""
    side = max(math.ceil(count ** (1 / 3)), 1)
    step = [6 / side, 4 / side, 1.4 / side]
    scale = 0.35 * min(step) / 0.1413
    text = "[materials.skin.lambert]\nreflectance = 0.35\n"
    for i in range(count):
        cell = [i % side, i // side % side, i // side**2]
        at = [step[k] * (cell[k] + 0.5) + (0.9 if k == 2 else 0.0) for k in range(3)]
        text += f"[objects.h{i}.sh]\nfile = {json.dumps(os.path.abspath(HEAD))}\ndegree = 32\n"
        text += f'at = {at}\nscale = {scale}\nmaterial = "skin"\n'
    return text


def scene(text):
    path = os.path.join(folder.name, f"{abs(hash(text))}.toml")
    with open(path, "w") as file:
        file.write(ROOM + text)
    return path


def run(path, walks, threads=1):
    """Seconds of the estimate, CPU seconds and the largest resident memory (bytes) of the
    process."""
    command = [TOOL, "--json", "-j", str(threads), "illum", path, "-D", f"illum.stop.walks={walks}"]
    with open(os.path.join(folder.name, "out.json"), "w+b") as out:
        child = subprocess.Popen(command, stdout=out, stderr=subprocess.DEVNULL)
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        if child.returncode:
            raise SystemExit(f"{' '.join(command)} ended with {child.returncode}")
        out.seek(0)
        seconds = json.load(out)["seconds"]
    return seconds, usage.ru_utime + usage.ru_stime, 1024 * usage.ru_maxrss


def slope(sizes, times):
    """The exponent: the slope of the logarithms, by least squares."""
    x, y = [math.log(v) for v in sizes], [math.log(v) for v in times]
    mx, my = statistics.fmean(x), statistics.fmean(y)
    return sum((a - mx) * (b - my) for a, b in zip(x, y)) / sum((a - mx) ** 2 for a in x)


def table(title, unit, cases, since):
    """Runs cases (size, scene, walks) in turns; the exponent is taken from size `since` on, below
    which other costs rule."""
    found = {size: [] for size, *_ in cases}
    for _ in range(TURNS):
        for size, path, walks in cases:
            found[size].append(run(path, walks))
    print(f"\n{title}\n{unit:>9}    seconds  exponent so far    memory")
    last = None
    for size, runs in found.items():
        seconds = statistics.median(s for s, *_ in runs)
        memory = max(m for *_, m in runs)
        local = (
            "" if last is None else f"{math.log(seconds / last[1]) / math.log(size / last[0]):.2f}"
        )
        print(f"{size:9} {seconds:10.4f} {local:>16} {memory / 1e6:8.0f} MB", flush=True)
        last = size, seconds
    fitted = [
        (size, statistics.median(s for s, *_ in runs))
        for size, runs in found.items()
        if size >= since
    ]
    print(f"exponent from {since} on: {slope(*zip(*fitted)):.2f}")


SHAPES = {
    1: (1, 1),
    10: (5, 2),
    100: (10, 10),
    1000: (40, 25),
    10_000: (125, 80),
    100_000: (400, 250),
    1_000_000: (1250, 800),
}
points = [n for n in SHAPES if n <= (10_000 if QUICK else 100_000)]
table("points, 1024 walks", "points", [(n, scene(grid(*SHAPES[n])), 1024) for n in points], 100)
room = scene(grid(12, 8))
table(
    "walks, 96 points",
    "walks",
    [(n, room, n) for n in (128, 512, 2048, 8192, 32768)[: 4 if QUICK else 5]],
    128,
)
crowds = (1, 10, 100, 1000)
table(
    "objects, 96 points, 1024 walks",
    "heads",
    [(n, scene(heads(n) + grid(12, 8)), 1024) for n in crowds],
    1,
)

print("\nthreads, 96 points, and 10 000")
for name, path, walks in (
    ("96 points, 8192 walks", room, 8192),
    ("10 000 points, 256 walks", scene(grid(125, 80)), 256),
):
    pairs = [(run(path, walks, 1), run(path, walks, 2)) for _ in range(TURNS + 2)]
    ratios = sorted(one[0] / two[0] for one, two in pairs)
    work = statistics.median(two[1] / one[1] for one, two in pairs)
    print(
        f"{name:26} two threads are {statistics.median(ratios):.2f} x one ({ratios[0]:.2f} to "
        f"{ratios[-1]:.2f}); CPU time of two / of one {work:.2f}",
        flush=True,
    )

seconds, cpu, memory = run(scene(grid(*SHAPES[1_000_000])), 32, os.cpu_count())
print(
    f"\na million points, 32 walks: {seconds:.1f} s on all threads, {memory / 1e9:.2f} GB, "
    f"{memory / 1e6:.0f} B a point"
)
