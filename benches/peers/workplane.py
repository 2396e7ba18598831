"""96 illuminances in a closed room: error over time of Harmolux and of Mitsuba 3's path tracer, in turns on the same machine.

    pip install mitsuba numpy
    cargo build --release
    python benches/peers/workplane.py target/release/harmolux

Both get the room of data/scenes/workplane.toml and all threads. What is timed is the estimate itself: for Harmolux the `seconds` of its JSON (without reading the
scene), for Mitsuba the call after one that compiles the kernel. The error is the rms of the relative error over the points, the mean over five seeds; the
reference is a long run of Harmolux, which a long run of Mitsuba must agree with.
"""
import json, subprocess, sys, time
import numpy as np, mitsuba as mi, drjit as dr

TOOL, SCENE, SEEDS = sys.argv[1], "data/scenes/workplane.toml", 5
SIZE = np.array([6.0, 4.0, 3.0])
LAMP = np.array([3.0, 2.0, 2.5])


def ours(walks, seed, estimator="local"):
    command = [TOOL, "--json", "illum", SCENE, "--seed", str(seed), "--estimator", estimator,
               "-D", f"illum.stop.walks={walks}"]
    result = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    sensors = result["rows"]
    points = np.array([[s["x_m"], s["y_m"], s["z_m"]] for s in sensors])
    return result["seconds"], points, np.array([s["illuminance_lx"] for s in sensors])


mi.set_variant("llvm_ad_mono")


def wall(corner, u, v, reflectance):
    corner, u, v = (np.array(x, float) for x in (corner, u, v))
    matrix = np.eye(4)
    normal = np.cross(u, v)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2] = u / 2, v / 2, normal / np.linalg.norm(normal)
    matrix[:3, 3] = corner + u / 2 + v / 2
    diffuse = {"type": "diffuse", "reflectance": {"type": "uniform", "value": reflectance}}
    return {"type": "rectangle", "to_world": mi.ScalarTransform4f(matrix), "bsdf": diffuse}


X, Y, Z = SIZE
room = mi.load_dict({
    "type": "scene",
    "floor": wall([0, 0, 0], [X, 0, 0], [0, Y, 0], 0.2), "ceiling": wall([0, 0, Z], [0, Y, 0], [X, 0, 0], 0.7),
    "x0": wall([0, 0, 0], [0, Y, 0], [0, 0, Z], 0.5), "x1": wall([X, 0, 0], [0, 0, Z], [0, Y, 0], 0.5),
    "y0": wall([0, 0, 0], [0, 0, Z], [X, 0, 0], 0.5), "y1": wall([0, Y, 0], [X, 0, 0], [0, 0, Z], 0.5),
    "lamp": {"type": "point", "position": list(LAMP), "intensity": {"type": "uniform", "value": 1.0}},
})
# Roulette from depth 5 on is Mitsuba's default; other depths were not tried.
path = mi.load_dict({"type": "path", "max_depth": -1, "rr_depth": 5})


def mitsuba(points, spp, seed):
    start, n = time.perf_counter(), len(points)
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(seed, n * spp)
    which = dr.arange(mi.UInt32, n * spp) // spp
    origin = dr.gather(mi.Point3f, mi.Point3f(points.T), which)
    direction = mi.warp.square_to_cosine_hemisphere(sampler.next_2d())
    light, _, _ = path.sample(room, sampler, mi.RayDifferential3f(mi.Ray3f(origin, direction)))
    light = np.array(light[0] if hasattr(light, "__len__") else light).reshape(n, spp)
    # The lamp itself, without noise as with us; nothing stands between.
    to_lamp = LAMP - points
    distance = np.linalg.norm(to_lamp, axis=1)
    direct = to_lamp[:, 2] / distance**3
    return time.perf_counter() - start, np.pi * light.mean(1) + direct


def rms(values, reference):
    return np.sqrt(np.mean([np.mean((v / reference - 1) ** 2) for v in values]))


_, points, reference = ours(1 << 21, 999)
mitsuba(points, 8, 0)
check = np.mean([mitsuba(points, 4096, 100 + k)[1] for k in range(8)], axis=0)
print(f"threads {dr.thread_count()}; mean {reference.mean():.6f} lx; rms difference of the references {rms([check], reference):.2e}")
print("program     walks or paths a point   seconds   rms error")
curves = {"harmolux": [], "path": [], "mitsuba": []}
for step in range(6):
    for name, work, run in [
        ("harmolux", 128 << step, lambda n, k: ours(n, k)[::2]),
        ("path", 512 << (2 * step), lambda n, k: ours(n, k, "path")[::2]),
        ("mitsuba", 16 << (2 * step), lambda n, k: mitsuba(points, n, k)),
    ]:
        run(work, 0)  # the first of a size may compile
        runs = [run(work, 1 + k) for k in range(SEEDS)]
        seconds, error = np.median([t for t, _ in runs]), rms([e for _, e in runs], reference)
        curves[name].append((seconds, error))
        print(f"{name:10} {work:14} {seconds:17.4f} {100 * error:10.3f} %")
for name, curve in curves.items():
    seconds, error = np.array(curve).T
    at = np.exp(np.interp(-np.log(0.01), -np.log(error), np.log(seconds)))
    outside = "" if error.min() <= 0.01 <= error.max() else " (outside of what was measured)"
    print(f"{name}: 1 % rms after {1000 * at:.1f} ms{outside}")
