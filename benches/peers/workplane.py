"""96 illuminances in a closed room: error over time of Harmolux, Mitsuba 3 and Radiance, in turns
on the same machine.

    pip install mitsuba numpy matplotlib pyradiance
    cargo build --release
    python benches/peers/workplane.py target/release/harmolux
        [--head] [--plot FILE.svg] [--steps 6] [--seeds 5] [--without-radiance]

All get the room of data/scenes/workplane.toml, or with --head that of workplane_head.toml, and all
threads. With the head Harmolux has it as spherical harmonics and as the mesh they were fitted to,
each against a reference of its own; the others have the mesh. Points inside the head are left out.

What is timed is the estimate itself: for Harmolux the `seconds` of its JSON (without reading the
scene), for Mitsuba the call after one that compiles the kernel, without the direct light of the
lamp, for Radiance the run of rtrace less one that traces nothing, its octree made before. The error
is the rms of the relative error over the points, the mean over the seeds; the reference is a long
run of Harmolux, which a long run of Mitsuba must agree with.

Mitsuba takes part twice: with independent samples and roulette from depth 8 on, as it is often
used, and with what was the fastest of independent, stratified, multijitter and ldsampler with
roulette from depth 2, 3, 5 or 8 on. Radiance runs a ladder of settings; what counts is the fastest
of them at each error.
"""

import argparse, json, os, subprocess, tempfile, time

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_mono")
import drjit as dr
from curves import plot, rest, time_to
from mitsuba_scene import Scene

HERE = os.path.dirname(os.path.abspath(__file__))
SCENES = os.path.join(HERE, "../../data/scenes")
TARGET = 0.01


def arguments():
    parser = argparse.ArgumentParser()
    parser.add_argument("tool")
    parser.add_argument("--head", action="store_true")
    parser.add_argument("--plot")
    parser.add_argument("--steps", type=int, default=6)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--reference", type=int, default=1 << 21, help="walks of the reference")
    parser.add_argument("--without-radiance", action="store_true")
    return parser.parse_args()


class Harmolux:
    """The tool on one scene file."""

    def __init__(self, tool, scene):
        self.tool, self.scene = tool, scene

    def rows(self, walks, seed, estimator="local"):
        command = [
            self.tool,
            "--json",
            "illum",
            self.scene,
            "--seed",
            str(seed),
            "--estimator",
            estimator,
            "-D",
            f"illum.stop.walks={walks}",
        ]
        result = json.loads(
            subprocess.run(
                command, check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
            ).stdout
        )
        return result["seconds"], result["rows"]

    def run(self, walks, seed, estimator="local"):
        seconds, rows = self.rows(walks, seed, estimator)
        return seconds, np.array([row["illuminance_lx"] for row in rows if row["behind"] is None])

    def points(self):
        return np.array(
            [
                [row[key] for key in ("x_m", "y_m", "z_m")]
                for row in self.rows(32, 0)[1]
                if row["behind"] is None
            ]
        )


def mesh_twin(scene, folder):
    """The scene file with its SH object as the mesh it was fitted to."""
    with open(scene) as file:
        text = file.read()
    text = text.replace("[objects.head.sh]", "[objects.head.mesh]").replace("degree = 32\n", "")
    text = text.replace(
        '"../head.obj"', json.dumps(os.path.abspath(os.path.join(SCENES, "../head.obj")))
    )
    path = os.path.join(folder, "mesh_twin.toml")
    with open(path, "w") as file:
        file.write(text)
    return path


class Mitsuba:
    """Mitsuba's path tracer from given points into the hemisphere above them."""

    def __init__(self, scene, tool, points):
        scene = Scene(scene, tool)
        self.scene, self.points = mi.load_dict(scene.dictionary()), points
        lamp = scene.spec["lights"]["lamp"]["point"]
        way = np.array(lamp["at"]) - points
        distance = np.linalg.norm(way, axis=1)
        shadow = mi.Ray3f(
            mi.Point3f(points.T),
            mi.Vector3f((way / distance[:, None]).T),
            mi.Float(distance * (1 - 1e-6)),
            0.0,
            mi.Color0f(),
        )
        self.direct = np.where(
            np.array(self.scene.ray_test(shadow)), 0.0, lamp["intensity"] * way[:, 2] / distance**3
        )

    def run(self, spp, seed, sampler="independent", roulette=8):
        path = mi.load_dict({"type": "path", "max_depth": -1, "rr_depth": roulette})
        start, n = time.perf_counter(), len(self.points)
        sampler = mi.load_dict({"type": sampler, "sample_count": spp})
        spp = sampler.sample_count()
        sampler.set_samples_per_wavefront(spp)
        sampler.seed(seed, n * spp)
        origin = dr.gather(
            mi.Point3f, mi.Point3f(self.points.T), dr.arange(mi.UInt32, n * spp) // spp
        )
        direction = mi.warp.square_to_cosine_hemisphere(sampler.next_2d())
        light, _, _ = path.sample(
            self.scene, sampler, mi.RayDifferential3f(mi.Ray3f(origin, direction))
        )
        light = np.array(light[0]).reshape(n, spp).mean(1)
        return time.perf_counter() - start, np.pi * light + self.direct

    def best_settings(self, reference, spp=1024):
        """The sampler and the start of roulette with the least time x squared error, the
        independent ones beside them."""
        costs = {}
        for sampler in ("independent", "stratified", "multijitter", "ldsampler"):
            for roulette in (2, 3, 5, 8):
                self.run(spp, 0, sampler, roulette)
                runs = [self.run(spp, 1 + k, sampler, roulette) for k in range(7)]
                costs[sampler, roulette] = (
                    np.median([t for t, _ in runs]) * rms([e for _, e in runs], reference) ** 2
                )
        return min(costs, key=costs.get)


def rms(values, reference):
    return np.sqrt(np.mean([np.mean((v / reference - 1) ** 2) for v in values]))


# What a practitioner of Radiance would try: with the ambient cache at several accuracies, and
# without it, by plain paths. What takes longer than LONGEST is given up.
LADDER = [
    f"-ab 5 -ad {ad} -as {ad // 4} -aa {aa} -ar 64"
    for ad in (128, 256, 512, 1024)
    for aa in (0.3, 0.2, 0.1)
]
LADDER += [
    f"-ab {ab} -ad {ad} -as 0 -aa 0 -lw {0.1 / ad:.2g}"
    for ab in (5, 8)
    for ad in (64, 256, 1024, 4096, 16384)
]
LONGEST = 20.0


def radiance(room, points, reference):
    """The settings that no other beats in both time and error, fastest first."""
    start, found = room.start(points), []
    for options in LADDER:
        try:
            runs = [room.trace(points, options, LONGEST) for _ in range(3)]
        except subprocess.TimeoutExpired:
            print(f"  rtrace {options:45} more than {LONGEST:.0f} s", flush=True)
            continue
        found.append(
            (
                max(np.median([t for t, _ in runs]) - start, 1e-4),
                rms([e for _, e in runs], reference),
                options,
            )
        )
        print(
            f"  rtrace {options:45} {found[-1][0]:8.3f} s {100 * found[-1][1]:8.3f} %", flush=True
        )
    found.sort()
    return [f for i, f in enumerate(found) if all(f[1] < g[1] for g in found[:i])]


def main():
    options = arguments()
    folder = tempfile.TemporaryDirectory()
    scene = os.path.normpath(
        os.path.join(SCENES, "workplane_head.toml" if options.head else "workplane.toml")
    )
    ours = {"": Harmolux(options.tool, scene)}
    if options.head:
        ours = {" SH": ours[""], " mesh": Harmolux(options.tool, mesh_twin(scene, folder.name))}
    points = list(ours.values())[-1].points()
    references = {name: tool.run(options.reference, 999)[1] for name, tool in ours.items()}
    reference = list(references.values())[-1]
    if len({len(r) for r in references.values()}) != 1:
        raise SystemExit("the series and the mesh hide different points")
    peer = Mitsuba(list(ours.values())[-1].scene, options.tool, points)
    check = np.mean([peer.run(4096, 100 + k, "multijitter", 8)[1] for k in range(16)], axis=0)
    print(
        f"{len(points)} points, mean {reference.mean():.6f} lx, threads {dr.thread_count()}, "
        f"Mitsuba {mi.__version__}"
    )
    print(
        "rms difference of the references of Harmolux and Mitsuba: "
        f"{rms([check], reference):.2e}, of the means {check.mean() / reference.mean() - 1:+.1e}"
    )
    if options.head:
        apart = np.abs(references[" SH"] / reference - 1)
        print(
            f"the series against its mesh: median difference {np.median(apart):.2e}, "
            f"{(apart > 0.05).sum()} points by more than 5 % (an edge of a shadow moves)"
        )
    sampler, roulette = peer.best_settings(reference)
    print(f"Mitsuba's fastest: {sampler}, roulette from depth {roulette} on\n")

    runs = []
    for name, tool in ours.items():
        runs.append(
            (
                f"Harmolux local{name}",
                references[name],
                lambda n, k, tool=tool: tool.run(n, k),
                lambda step: 128 << step,
            )
        )
        runs.append(
            (
                f"Harmolux path{name}",
                references[name],
                lambda n, k, tool=tool: tool.run(n, k, "path"),
                lambda step: 512 << (2 * step),
            )
        )
    runs.append(
        (
            "Mitsuba, independent",
            reference,
            lambda n, k: peer.run(n, k),
            lambda step: 16 << (2 * step),
        )
    )
    runs.append(
        (
            f"Mitsuba, {sampler}",
            reference,
            lambda n, k: peer.run(n, k, sampler, roulette),
            lambda step: 16 << (2 * step),
        )
    )
    curves = {name: [] for name, *_ in runs}
    print("program                    walks or paths a point    seconds   rms error")
    for step in range(options.steps):
        for name, truth, run, work in runs:
            run(work(step), 0)  # the first of a size may compile
        found = {name: [] for name, *_ in runs}
        for seed in range(options.seeds):
            for name, truth, run, work in runs:
                rest()
                found[name].append(run(work(step), 1 + seed))
        for name, truth, run, work in runs:
            seconds, error = (
                np.median([t for t, _ in found[name]]),
                rms([e for _, e in found[name]], truth),
            )
            curves[name].append((seconds, error))
            print(f"{name:26} {work(step):22} {seconds:10.4f} {100 * error:9.3f} %", flush=True)
    if not options.without_radiance:
        from radiance_room import RadianceRoom

        twin = Scene(list(ours.values())[-1].scene, options.tool).spec
        mesh = (
            (os.path.join(SCENES, "../head.obj"), twin["objects"]["head"]["mesh"])
            if options.head
            else None
        )
        curves["Radiance"] = radiance(
            RadianceRoom(twin, mesh, dr.thread_count()), points, reference
        )
    base = time_to(next(iter(curves.values())), TARGET)[0]
    print()
    for name, curve in curves.items():
        seconds, outside = time_to(curve, TARGET)
        note = " (outside of what was measured)" if outside else ""
        print(f"{name:26} 1 % rms after {1000 * seconds:8.1f} ms, {seconds / base:6.1f} x{note}")
    if options.plot:
        plot(
            curves,
            "96 points in a closed room" + (", with a head" if options.head else ""),
            options.plot,
            "rms relative error, %",
            100.0,
            TARGET,
        )


if __name__ == "__main__":
    main()
