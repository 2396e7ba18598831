"""A room with a point lamp for Radiance's rtrace: one box inward, one isotropic lamp, and perhaps
one mesh, as in data/scenes/workplane*.toml.

Radiance has no point lights: a sphere of 5 mm stands for the lamp, which changes an illuminance 1.7
m away by less than 1e-5.
"""

import os, subprocess, tempfile, time

import numpy as np

RADIUS = 0.005


class RadianceRoom:
    """The room as an octree, made apart from what is timed."""

    def __init__(self, spec, mesh=None, threads=2):
        import pyradiance

        home = os.path.dirname(pyradiance.__file__)
        binaries, library = (os.path.join(home, name) for name in ("bin", "lib"))
        self.environment = dict(
            os.environ, RAYPATH=".:" + library, PATH=binaries + ":" + os.environ["PATH"]
        )
        self.folder, self.threads = tempfile.TemporaryDirectory(), threads
        with open(os.path.join(self.folder.name, "room.rad"), "w") as file:
            file.write("".join(self.describe(spec, mesh)))
        octree = self.run(["oconv", "room.rad"])
        with open(os.path.join(self.folder.name, "room.oct"), "wb") as file:
            file.write(octree)

    def run(self, command, stdin=b"", longest=None):
        return subprocess.run(
            command,
            timeout=longest,
            cwd=self.folder.name,
            env=self.environment,
            input=stdin,
            check=True,
            capture_output=True,
        ).stdout

    def describe(self, spec, mesh):
        for name, kind in spec["materials"].items():
            r = kind["lambert"]["reflectance"]
            yield f"void plastic {name} 0 0 5 {r} {r} {r} 0 0\n"
        lamp = spec["lights"]["lamp"]["point"]
        radiance = lamp["intensity"] / (np.pi * RADIUS**2)
        at = " ".join(map(str, lamp["at"]))
        yield f"void light shining 0 0 3 {radiance} {radiance} {radiance}\n"
        yield f"shining sphere lamp 0 0 4 {at} {RADIUS}\n"
        room = spec["objects"]["room"]["box"]
        low, high = (np.array(room[key], float) for key in ("min", "max"))
        edges = np.diag(high - low)
        for axis, letter in enumerate("xyz"):
            u, v = edges[(axis + 1) % 3], edges[(axis + 2) % 3]
            for end, corner, first, second in (
                ("min", low, u, v),
                ("max", low + edges[axis], v, u),
            ):
                material = room.get("faces", {}).get(f"{letter}_{end}", room["material"])
                corners = np.concatenate(
                    [corner, corner + first, corner + first + second, corner + second]
                )
                yield f"{material} polygon {letter}_{end} 0 0 12 {' '.join(map(str, corners))}\n"
        if mesh:
            file, head = mesh
            self.run(["obj2mesh", os.path.abspath(file), "head.rtm"])
            at = " ".join(map(str, head["at"]))
            yield f"{head['material']} mesh head 7 head.rtm -s {head['scale']} -t {at} 0 0\n"

    def trace(self, points, options, longest=None):
        """The illuminances of points that face up, and the time of rtrace, its start included."""
        sensors = "".join(f"{x} {y} {z} 0 0 1\n" for x, y, z in points).encode()
        start = time.perf_counter()
        out = self.run(
            ["rtrace", "-I", "-h", "-n", str(self.threads), *options.split(), "room.oct"],
            sensors,
            longest,
        )
        seconds = time.perf_counter() - start
        return seconds, np.array(
            [float(line.split()[1]) for line in out.decode().splitlines() if line.strip()]
        )

    def start(self, points):
        """The time that rtrace takes before it traces anything: the least of several runs with one
        point and no interreflection."""
        return min(self.trace(points[:1], "-ab 0")[0] for _ in range(5))
