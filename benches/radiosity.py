"""The local estimate against radiosity: time to equal error at ten points of Sobolev's case A
between discs, and at 96 points of a closed room.

    pip install numpy
    cargo build --release
    python3 benches/radiosity.py target/release/harmolux

One thread. Times are the `seconds` of the JSON, the median of three runs; the local estimate has
eight seeds, which take turns with radiosity. Between the discs (radius 10 at a gap of 1,
reflectance a half, the source in the middle; 0 <= r <= 3) the error is the paper's, the largest
|dE| / E(0), against the exact solution; in the room of data/scenes/workplane.toml it is the rms of
the relative error, against a long run of the local estimate. The mean over the seeds is the
quadratic one.

Radiosity is as good as its patches are: here graded discs and contour form factors, and a final
gather at the points. `harmolux exact sobolev` has the solution of the one-dimensional integral
equation, which beats both where it applies.
"""

import json, math, os, statistics, subprocess, sys, tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "peers"))
from curves import time_to

if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
    sys.exit(__doc__)
TOOL = sys.argv[1]
SCENES = os.path.join(HERE, "../data/scenes")
PATCHES = [100, 200, 500, 1000, 2000, 4000]
WALKS = [256 * 4**k for k in range(6)]
SEEDS = 8


def run(scene, *settings):
    """Seconds, and the rows of the sensors."""
    command = [TOOL, "--json", "-j", "1", "illum", scene]
    for setting in settings:
        command += ["-D", setting]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if done.returncode not in (
        0,
        4,
    ):  # 4: radiosity does not agree with the exact answer to its digits
        raise SystemExit(f"{' '.join(command)} ended with {done.returncode}: {done.stderr}")
    report = json.loads(done.stdout)
    return report["seconds"], report["rows"]


def values(rows):
    return [row["illuminance_lx"] for row in rows]


def ten_points(folder):
    with open(os.path.join(SCENES, "sobolev_discs.toml")) as file:
        lines = file.read().splitlines()
    at = [[round(k / 3, 12), 0, 0] for k in range(10)]
    lines = [f"at = {at}" if line.startswith("at = [[") else line for line in lines]
    path = os.path.join(folder, "ten_points.toml")
    with open(path, "w") as file:
        file.write("\n".join(lines))
    return path


def largest(found, exact):
    return max(abs(f - e) for f, e in zip(found, exact)) / exact[0]


def rms(found, exact):
    return math.sqrt(statistics.fmean((f / e - 1) ** 2 for f, e in zip(found, exact)))


def compare(title, scene, exact, error):
    print(f"\n{title}\n{'':12}{'patches, walks':>16}{'seconds':>12}{'error':>12}")
    radiosity, local = [], []
    for patches, walks in zip(PATCHES, WALKS):
        runs = []
        found = []
        for seed in range(SEEDS):
            found.append(
                run(
                    scene,
                    'illum.estimator="local"',
                    f"illum.seed={seed + 1}",
                    f"illum.stop.walks={walks}",
                )
            )
            if seed < 3:
                runs.append(run(scene, 'illum.estimator="radiosity"', f"illum.patches={patches}"))
        radiosity.append((statistics.median(t for t, _ in runs), error(values(runs[0][1]), exact)))
        local.append(
            (
                statistics.median(t for t, _ in found),
                math.sqrt(statistics.fmean(error(values(r), exact) ** 2 for _, r in found)),
            )
        )
        for name, size, (seconds, off) in (
            ("radiosity", patches, radiosity[-1]),
            ("local", walks, local[-1]),
        ):
            print(f"{name:12}{size:16}{seconds:12.4f}{100 * off:10.3f} %", flush=True)
    for seconds, off in radiosity:
        own, outside = time_to(local, off)
        if not outside:
            print(
                f"to {100 * off:.3f} %: radiosity {seconds:.4f} s, the local estimate {own:.4f} "
                f"s: {seconds / own:.1f} times"
            )


with tempfile.TemporaryDirectory() as folder:
    scene = ten_points(folder)
    _, rows = run(scene, "illum.stop.walks=32")
    compare(
        "Sobolev's case A between discs, ten points, largest |dE| / E(0)",
        scene,
        [row["exact_lx"] for row in rows],
        largest,
    )
    scene = os.path.join(SCENES, "workplane.toml")
    _, rows = run(scene, f"illum.stop.walks={1 << 21}", "illum.seed=99")
    compare("Closed room, 96 points, rms of the relative error", scene, values(rows), rms)
