"""What the measurements of how runs end have in common."""

import argparse
from pathlib import Path

ROOM = """format = 1
[materials.grey.lambert]
reflectance = 0.5
[objects.room.box]
min = [0, 0, 0]
max = [4, 5, 3]
inward = true
material = "grey"
[lights.lamp.point]
at = [2, 2.5, 2.8]
intensity = 200
"""

CAMERA = """[cameras.main.perspective]
from = [1, 1, 1.5]
to = [3, 4, 1]
fov = 60
"""

SENSOR = """[sensors.one.points]
at = [[1, 1, 0]]
normal = [0, 0, 1]
"""


def grid(side):
    """Returns side^2 sensors on the floor."""
    return f'[sensors.floor.grid]\non = "room.z_min"\ncount = [{side}, {side}]\n'


def body(file, degree, keys="", material="grey"):
    """Returns a shape in the room."""
    return (
        f'[objects.body.sh]\nfile = "{file}"\ndegree = {degree}\n{keys}'
        f'at = [2, 2.5, 1.5]\nmaterial = "{material}"\n'
    )


def put(folder, files):
    """Writes files, by their names."""
    for name, text in files.items():
        Path(folder, name).write_text(text)


def parser(documentation):
    """Returns a parser that takes the tool, and says what a script does by its first lines."""
    arguments = argparse.ArgumentParser(description=documentation.split("\n\n")[0])
    tool = lambda text: str(Path(text).resolve())
    arguments.add_argument("tool", nargs="?", default="target/release/harmolux", type=tool)
    return arguments
