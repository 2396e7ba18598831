"""Scene files of Harmolux for Mitsuba 3: the objects, materials, lights and cameras that both
programs have, as a dictionary for `mitsuba.load_dict`.

Covered: box, rectangle, disc, sphere, mesh and sh (tessellated by `harmolux mesh`); lambert, with
exitance; isotropic point lights; the perspective camera. All else is refused by name, since a
picture without it would be compared with one that has it: among the materials metal and coated,
whose models differ from Mitsuba's in what they do with the light between the facets.

Flat things become two triangles, which Embree, inside Mitsuba, meets faster than Mitsuba's own
rectangle. Choose the variant of Mitsuba before importing this.
"""

import os, subprocess, tempfile, tomllib

import mitsuba as mi
import numpy as np

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
# The unit of a file in metres, and what turns its up axis to z.
UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}
UP = {
    "z": np.eye(3),
    "y": np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0.0]]),
    "x": np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0.0]]),
}
# Each edge of an icosahedron is cut into so many: 327 680 faces.
FREQUENCY = 128


def refuse(what):
    raise SystemExit(f"{what}: not covered by this comparison; see the head of mitsuba_scene.py")


def only(table):
    """The type of a named thing, and its keys."""
    return next(iter(table.items()))


def grey(value):
    """A number or a triple as a colour."""
    value = [value] * 3 if isinstance(value, (int, float)) else list(value)
    if mi.variant().endswith("mono"):
        return {"type": "uniform", "value": float(np.dot(value, LUMINANCE))}
    return {"type": "rgb", "value": value}


def placement(spec):
    """The 4 x 4 matrix that puts the numbers of a file into the room."""
    scale = spec.get("scale", 1.0) * UNITS[spec.get("unit", "m")]
    turn = spec.get("rotate", {"axis": [0, 0, 1], "degrees": 0.0})
    rotation = mi.ScalarTransform4f().rotate(turn["axis"], turn["degrees"])
    matrix = np.array(rotation.matrix, dtype=float).reshape(4, 4)
    matrix[:3, :3] = scale * matrix[:3, :3] @ UP[spec.get("up", "z")]
    matrix[:3, 3] = spec.get("at", [0, 0, 0])
    return matrix


class Scene:
    """A scene file, read; its files are made in a folder that lives as long as this does."""

    def __init__(self, path, tool):
        self.path, self.tool = path, tool
        with open(path, "rb") as file:
            self.spec = tomllib.load(file)
        self.folder = tempfile.TemporaryDirectory()

    def file(self, spec):
        return os.path.join(os.path.dirname(os.path.abspath(self.path)), spec["file"])

    def material(self, name, two_sided):
        """A material's reflection and its emission, each None where there is none."""
        kind, spec = only(self.spec["materials"][name])
        if kind != "lambert":
            refuse(f"{self.path}: [materials.{name}.{kind}]")
        bsdf = {"type": "diffuse", "reflectance": grey(spec["reflectance"])}
        bsdf = {"type": "twosided", "bsdf": bsdf} if two_sided else bsdf
        exitance = np.array(spec.get("exitance", 0.0), float)
        emitter = (
            {"type": "area", "radiance": grey((exitance / np.pi).tolist())}
            if exitance.any()
            else None
        )
        return {"bsdf": bsdf} | ({"emitter": emitter} if emitter else {})

    def flat(self, name, corner, u, v, material, two_sided):
        """A rectangle whose normal is u x v."""
        corner, u, v = (np.array(x, float) for x in (corner, u, v))
        path = os.path.join(self.folder.name, name + ".ply")
        vertices = [corner, corner + u, corner + u + v, corner + v]
        head = (
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
            "property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n"
        )
        with open(path, "w") as file:
            file.write(
                head
                + "".join(f"{x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in vertices)
                + "3 0 1 2\n3 0 2 3\n"
            )
        return {"type": "ply", "filename": path, "face_normals": True} | self.material(
            material, two_sided
        )

    def box(self, name, spec):
        low, high = (np.array(spec[key], float) for key in ("min", "max"))
        edges, inward = np.diag(high - low), spec.get("inward", False)
        for axis, letter in enumerate("xyz"):
            u, v = edges[(axis + 1) % 3], edges[(axis + 2) % 3]
            for end, corner, in_at in (("min", low, True), ("max", low + edges[axis], False)):
                face = f"{letter}_{end}"
                material = spec.get("faces", {}).get(face, spec["material"])
                first, second = (u, v) if in_at == inward else (v, u)
                yield (
                    f"{name}_{face}",
                    self.flat(f"{name}_{face}", corner, first, second, material, False),
                )

    def tessellated(self, name, spec):
        """The series itself as a fine mesh, made by the tool; in the coordinates of the file it
        came from."""
        series, mesh = (os.path.join(self.folder.name, name + end) for end in (".txt", ".ply"))
        quiet = dict(check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        if "centre" in spec:
            refuse(f"{self.path}: `centre` of [objects.{name}.sh]")
        subprocess.run(
            [self.tool, "fit", self.file(spec), "-l", str(spec["degree"]), "-o", series], **quiet
        )
        subprocess.run(
            [self.tool, "mesh", series, "-o", mesh, "--resolution", str(FREQUENCY)], **quiet
        )
        return mesh

    def objects(self):
        for name, thing in self.spec.get("objects", {}).items():
            kind, spec = only(thing)
            if kind == "box":
                yield from self.box(name, spec)
            elif kind == "rectangle":
                yield (
                    name,
                    self.flat(
                        name, spec["corner"], spec["edge_u"], spec["edge_v"], spec["material"], True
                    ),
                )
            elif kind == "disc":
                frame = mi.ScalarTransform4f().look_at(
                    spec["centre"],
                    list(np.add(spec["centre"], spec["normal"])),
                    [0, 0, 1] if abs(spec["normal"][2]) < 0.9 else [0, 1, 0],
                )
                yield (
                    name,
                    {"type": "disk", "to_world": frame.scale(spec["radius"])}
                    | self.material(spec["material"], True),
                )
            elif kind == "sphere":
                shape = {
                    "type": "sphere",
                    "center": spec["centre"],
                    "radius": spec["radius"],
                    "flip_normals": spec.get("inward", False),
                }
                yield name, shape | self.material(spec["material"], False)
            elif kind in ("mesh", "sh"):
                flat = kind == "mesh" and not spec.get("smooth", False)
                file = self.file(spec) if kind == "mesh" else self.tessellated(name, spec)
                shape = {
                    "type": file.rsplit(".", 1)[1],
                    "filename": file,
                    "face_normals": flat,
                    "to_world": mi.ScalarTransform4f(placement(spec)),
                }
                yield name, shape | self.material(spec["material"], kind == "mesh")
            else:
                refuse(f"{self.path}: [objects.{name}.{kind}]")

    def lights(self):
        for name, thing in self.spec.get("lights", {}).items():
            kind, spec = only(thing)
            if kind != "point":
                refuse(f"{self.path}: [lights.{name}.{kind}]")
            colour = np.array(spec.get("colour", [1, 1, 1]), float)
            intensity = spec["intensity"] if "intensity" in spec else spec["flux"] / (4 * np.pi)
            yield (
                name,
                {
                    "type": "point",
                    "position": spec["at"],
                    "intensity": grey((intensity * colour / (colour @ LUMINANCE)).tolist()),
                },
            )

    def dictionary(self):
        return {"type": "scene"} | dict(self.objects()) | dict(self.lights())

    def camera(self, size, filter):
        kind, spec = only(next(iter(self.spec["cameras"].values())))
        if kind != "perspective":
            refuse(f"{self.path}: a camera of type {kind}")
        film = {"type": "hdrfilm", "width": size[0], "height": size[1], "rfilter": filter}
        view = mi.ScalarTransform4f().look_at(spec["from"], spec["to"], spec.get("up", [0, 0, 1]))
        return {
            "type": "perspective",
            "fov": spec["fov"],
            "fov_axis": "y",
            "to_world": view,
            "film": film,
        }
