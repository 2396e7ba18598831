"""Pictures of our scene files: relMSE over time of Harmolux and of Mitsuba 3's path tracer, in
turns on the same machine, and whether both mean the same picture.

    pip install mitsuba numpy scipy matplotlib
    cargo build --release
    python benches/peers/pictures.py target/release/harmolux data/scenes/cornell_head.toml
        [--size 128x128] [--steps 4] [--seeds 3] [--plot FILE.svg] [--rays 1024] [--spp 4096]
        [--estimators double-local,path] [--filter box] [--without-curves]

First long runs in 32 parts of Mitsuba and of each estimator (double-local-a and double-local-b
too): the means of the pictures must agree within 0.2 per cent, and all pixels jointly, |a - b| <=
t(0.001/n; 31) sqrt(se_a^2 + se_b^2), with the errors that Harmolux claims and those of Mitsuba's
parts. Then short runs of growing size in turns; their relMSE = mean((x - r)^2 / (r^2 + 1e-4
mean(r)^2)) of the luminance against the mean r of the first estimator's long run and Mitsuba's,
less what the error of that mean adds. Times are without start and compilation: the `seconds` of our
JSON, and the call of Mitsuba after one of the same size.

A pixel on an edge of a bright lamp is decided by few samples: with less than some hundred eye rays
its error is not known well enough for the joint test.

SH objects are triangles for Mitsuba, 327 680 of them, with smooth normals. Its sampler and the
start of its roulette are the fastest of a few.
"""

import argparse, json, os, subprocess, tempfile, time

import mitsuba as mi
import numpy as np
from scipy import stats

mi.set_variant("llvm_ad_rgb")
import drjit as dr
from mitsuba_scene import LUMINANCE, Scene
from curves import plot, rest, time_to

SINGLE = 2**-22
PARTS = 32


def arguments():
    parser = argparse.ArgumentParser()
    parser.add_argument("tool")
    parser.add_argument("scene")
    parser.add_argument("--size", default="128x128")
    parser.add_argument("--steps", type=int, default=4)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument(
        "--rays",
        type=int,
        default=1024,
        help="eye rays per pixel of our long run; each has 32 walks, or 8 paths",
    )
    parser.add_argument(
        "--spp", type=int, default=4096, help="paths per pixel of Mitsuba's long run"
    )
    parser.add_argument("--estimators", default="double-local,path")
    parser.add_argument("--filter", choices=("box", "tent"), default="box")
    parser.add_argument("--without-curves", action="store_true")
    parser.add_argument("--plot")
    return parser.parse_args()


def channels(path):
    bitmap = mi.Bitmap(path)
    values = np.array(bitmap).astype(float)
    names = [field.name for field in bitmap.struct_()]
    return {name: values[..., i] for i, name in enumerate(names)}


def inner(picture, options):
    """Leaves out the pixels at the border for a filter that reaches beyond it: we look there,
    Mitsuba takes what is within for the whole."""
    return picture if options.filter == "box" else picture[1:-1, 1:-1]


class Harmolux:
    def __init__(self, options):
        self.options, self.folder = options, tempfile.TemporaryDirectory()

    def run(self, rays, seed, estimator):
        """Seconds, luminance and its standard error, and the relative error of the mean of the
        picture."""
        walks = rays * (8 if estimator == "path" else 32)
        out = os.path.join(self.folder.name, "picture.exr")
        command = [
            self.options.tool,
            "--json",
            "render",
            self.options.scene,
            "--seed",
            str(seed),
            "--size",
            self.options.size,
            "-o",
            out,
            "--force",
        ]
        sets = {
            "stop": f"{{ walks = {walks} }}",
            "estimator": f'"{estimator}"',
            "filter": f'"{self.options.filter}"',
        }
        if self.options.filter == "tent":
            del sets["filter"]
        for key, value in sets.items():
            command += ["-D", f"render.{key}={value}"]
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        if done.returncode:
            raise SystemExit(f"{' '.join(command)}\n{done.stderr}")
        layers = channels(out)
        report = json.loads(done.stdout)
        return (
            report["seconds"],
            inner(layers["luminance.Y"], self.options),
            inner(layers["stderr.Y"], self.options),
            report["mean_luminance_standard_error"] / report["mean_luminance"],
        )


class Mitsuba:
    def __init__(self, options):
        self.options = options
        scene = Scene(options.scene, options.tool)
        size = [int(n) for n in options.size.split("x")]
        # Our box is one pixel wide, our tent two.
        kernel = {"type": options.filter} | ({"radius": 1.0} if options.filter == "tent" else {})
        self.scene = mi.load_dict(scene.dictionary())
        self.sensors = {
            sampler: mi.load_dict(scene.camera(size, kernel) | {"sampler": {"type": sampler}})
            for sampler in ("independent", "stratified", "multijitter")
        }

    def run(self, spp, seed, sampler="independent", roulette=5):
        """Seconds and luminance."""
        path = mi.load_dict({"type": "path", "max_depth": -1, "rr_depth": roulette})
        start = time.perf_counter()
        image = np.array(
            mi.render(self.scene, sensor=self.sensors[sampler], integrator=path, spp=spp, seed=seed)
        )
        return time.perf_counter() - start, inner(
            image[..., :3].astype(float) @ LUMINANCE, self.options
        )

    def best_settings(self, reference, spp=64):
        """The sampler and the start of roulette with the least time x relMSE."""
        costs = {}
        for sampler in self.sensors:
            for roulette in (3, 5, 8):
                self.run(spp, 0, sampler, roulette)
                runs = [self.run(spp, 1 + k, sampler, roulette) for k in range(3)]
                costs[sampler, roulette] = np.median([t for t, _ in runs]) * np.mean(
                    [relative(x, reference) for _, x in runs]
                )
        return min(costs, key=costs.get)


def relative(x, reference):
    """relMSE of a luminance."""
    return np.mean((x - reference) ** 2 / (reference**2 + 1e-4 * reference.mean() ** 2))


def compare(a, a_error, b, b_error, mean_error):
    """Tells whether two long runs mean the same picture."""
    apart = a.mean() / b.mean() - 1
    print(
        f"image means {a.mean():.5f} and {b.mean():.5f} cd/m2: {100 * apart:+.3f} % apart "
        f"(standard error {100 * mean_error:.3f} %), "
        f"{'within' if abs(apart) <= 0.002 else 'BEYOND'} 0.2 %"
    )
    # Both pictures hold single precision: pixels without noise, as on a lamp, may differ by its
    # last digit.
    apart = np.maximum(np.abs(a - b) - SINGLE * b, 0)
    z = apart / np.maximum(np.sqrt(a_error**2 + b_error**2), 1e-9 * b.mean())
    limit = stats.t.ppf(1 - 0.001 / (2 * z.size), PARTS - 1)
    print(
        f"joint test of {z.size} pixels: largest |z| {z.max():.2f}, limit {limit:.2f}: "
        f"{'equal' if z.max() <= limit else 'NOT EQUAL'}; {(z > limit).sum()} pixels beyond"
    )
    if z.max() > limit:
        for row, column in np.argwhere(z > limit)[:8]:
            print(f"  row {row} column {column}: {a[row, column]:.5g} against {b[row, column]:.5g}")


def long_runs(ours, peer, options):
    """Holds a long run of every estimator to one of Mitsuba; gives the mean of the first and
    Mitsuba's, and what its error adds to relMSE."""
    parts, start = [], time.perf_counter()
    for k in range(PARTS):
        parts.append(peer.run(max(options.spp // PARTS, 1), 9001 + k)[1])
    b, b_error = np.mean(parts, 0), np.std(parts, 0, ddof=1) / np.sqrt(PARTS)
    print(
        f"Mitsuba {mi.__version__}: {options.spp} paths a pixel, "
        f"{time.perf_counter() - start:.1f} s, relMSE by its own errors "
        f"{relative(b + b_error, b):.2e}",
        flush=True,
    )
    means = np.array([part.mean() for part in parts])
    b_mean_error = means.std(ddof=1) / np.sqrt(PARTS) / means.mean()
    first = None
    for estimator in options.estimators.split(","):
        seconds, a, a_error, a_mean_error = ours.run(options.rays, 7001, estimator)
        print(
            f"Harmolux {estimator}: {options.rays} eye rays a pixel, {seconds:.1f} s, relMSE by "
            f"its own errors {relative(a + a_error, a):.2e}"
        )
        compare(a, a_error, b, b_error, np.hypot(a_mean_error, b_mean_error))
        first = first or (a, a_error)
    a, a_error = first
    # Weighted by their variance over the whole picture, which needs no knowledge of the pixels
    # themselves.
    weight = 1 / np.mean(a_error**2), 1 / np.mean(b_error**2)
    reference = (weight[0] * a + weight[1] * b) / sum(weight)
    error = np.sqrt((weight[0] * a_error) ** 2 + (weight[1] * b_error) ** 2) / sum(weight)
    return reference, relative(reference + error, reference)


def main():
    options = arguments()
    ours, peer = Harmolux(options), Mitsuba(options)
    print(f"{options.scene}, {options.size}, {options.filter} filter, {dr.thread_count()} threads")
    reference, floor = long_runs(ours, peer, options)
    if options.without_curves:
        return
    sampler, roulette = peer.best_settings(reference)
    print(
        f"Mitsuba's fastest: {sampler}, roulette from depth {roulette} on; the reference adds "
        f"{floor:.1e}, which is taken off"
    )
    runs = [
        (
            f"Harmolux {name}",
            lambda n, k, name=name: ours.run(n, k, name)[:2],
            lambda step: 2 << (2 * step),
        )
        for name in options.estimators.split(",")
    ] + [
        (
            f"Mitsuba, {sampler}",
            lambda n, k: peer.run(n, k, sampler, roulette),
            lambda step: 16 << (2 * step),
        )
    ]
    curves = {name: [] for name, *_ in runs}
    print("program                  eye rays a pixel    seconds      relMSE   relMSE x s")
    for step in range(options.steps):
        found = {name: [] for name, *_ in runs}
        for name, run, work in runs:
            run(work(step), 0)  # the first of a size may compile
        for seed in range(options.seeds):
            for name, run, work in runs:
                rest()
                found[name].append(run(work(step), 1 + seed))
        for name, _, work in runs:
            seconds = np.median([t for t, _ in found[name]])
            error = max(np.mean([relative(x, reference) for _, x in found[name]]) - floor, 1e-12)
            curves[name].append((seconds, error))
            print(
                f"{name:24} {work(step):16} {seconds:10.3f} {error:11.3e} {seconds * error:12.3e}",
                flush=True,
            )
    # The least error that all have reached.
    target = max(min(e for _, e in curve) for curve in curves.values())
    print()
    peer_time, _ = time_to(curves[runs[-1][0]], target)
    for name, curve in curves.items():
        seconds, outside = time_to(curve, target)
        print(
            f"{name:24} relMSE {target:.2e} after {seconds:8.3f} s; Mitsuba takes "
            f"{peer_time / seconds:5.2f} times "
            f"that{' (outside of what was measured)' if outside else ''}"
        )
    if options.plot:
        name = os.path.splitext(os.path.basename(options.scene))[0]
        plot(curves, f"{name}, {options.size} pixels", options.plot, "relMSE", 1.0, None)


if __name__ == "__main__":
    main()
