"""Read what harmolux writes by pyshtools, healpy, ducc0 and scipy, and compare radii with those of
its own text.

    cargo build --release
    venv/bin/python tests/interop/check.py target/release/harmolux

For the shape of degree 12 of tests/data/interop and the head at degree 32: each format is written
by `convert`, read by the package it is made for, and evaluated there in 500 directions; the largest
relative difference of the radii must be below 1e-12.
"""

import pathlib
import subprocess
import sys
import tempfile

import ducc0
import healpy
import numpy as np
import pyshtools
from scipy.special import sph_harm_y

ROOT = pathlib.Path(__file__).parent.parent.parent
TOLERANCE = 1e-12


def tool(*arguments):
    subprocess.run(
        [str(HARMOLUX), *map(str, arguments)],
        check=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
    )


def directions():
    random = np.random.default_rng(500)
    z = random.uniform(-1, 1, 500)
    theta, phi = np.arccos(z), random.uniform(0, 2 * np.pi, 500)
    # The poles, where formulas divide by zero, are not left out.
    theta[:2], phi[:2] = [0, np.pi], 0
    return theta, phi


THETA, PHI = directions()


def from_pyshtools(coefficients):
    return coefficients.expand(lat=np.degrees(np.pi / 2 - THETA), lon=np.degrees(PHI))


def harmonics(values, lmax):
    """Sum over a_lm in healpy's order by scipy's harmonics: f = sum a_l0 Y_l0 + 2 Re sum a_lm
    Y_lm."""
    total = np.zeros(len(THETA))
    for l in range(lmax + 1):
        for m in range(l + 1):
            term = values[healpy.Alm.getidx(lmax, l, m)] * sph_harm_y(l, m, THETA, PHI)
            total += term.real * (1 if m == 0 else 2)
    return total


def from_ducc0(path, lmax):
    alm = np.load(path)[None]
    return ducc0.sht.synthesis_general(
        alm=alm, spin=0, lmax=lmax, loc=np.stack([THETA, PHI], axis=1), epsilon=2e-14
    )[0]


def from_healpy(path, lmax):
    """healpy evaluates at its pixels only: compared there with scipy's sum of the same numbers, and
    scipy's sum in our directions."""
    alm = np.load(path)
    pixels = healpy.alm2map(alm, 32, lmax=lmax)
    global THETA, PHI
    kept = THETA, PHI
    THETA, PHI = healpy.pix2ang(32, np.arange(0, len(pixels), 25))
    apart = np.max(np.abs(harmonics(alm, lmax) / pixels[::25] - 1))
    THETA, PHI = kept
    assert apart <= TOLERANCE, f"healpy and scipy differ by {apart:.1e}"
    return harmonics(alm, lmax)


def from_spharm_pdm(path):
    """The set of points: their distance from the centre, and how far they lie beside their
    direction."""
    numbers = [float(v) for v in path.read_text().translate(str.maketrans("{},", "   ")).split()]
    rows = np.array(numbers[1:]).reshape(-1, 3)
    assert len(rows) == numbers[0]
    points = np.zeros((3, len(THETA)))
    for l in range(int(np.sqrt(len(rows)))):
        points += rows[l * l][:, None] * sph_harm_y(l, 0, THETA, PHI).real
        for m in range(1, l + 1):
            y = sph_harm_y(l, m, THETA, PHI)
            points += (
                rows[l * l + 2 * m - 1][:, None] * y.real + rows[l * l + 2 * m][:, None] * y.imag
            )
    omega = np.stack([np.sin(THETA) * np.cos(PHI), np.sin(THETA) * np.sin(PHI), np.cos(THETA)])
    radius = np.sum(points * omega, axis=0)
    beside = np.max(np.linalg.norm(points - radius * omega, axis=0) / radius)
    assert beside <= TOLERANCE, f"points lie {beside:.1e} beside their directions"
    return radius


def from_aics(path):
    lines = [line.split(",") for line in path.read_text().splitlines()]
    values = dict(zip(lines[0], lines[1]))
    lmax = max(int(name[10:].split("M")[0]) for name in values if name.startswith("shcoeffs_L"))
    c = np.zeros((2, lmax + 1, lmax + 1))
    for l in range(lmax + 1):
        for m in range(lmax + 1):
            c[0, l, m], c[1, l, m] = (
                float(values[f"shcoeffs_L{l}M{m}C"]),
                float(values[f"shcoeffs_L{l}M{m}S"]),
            )
    lat, lon = np.degrees(np.pi / 2 - THETA), np.degrees(PHI + np.pi)
    return pyshtools.SHCoeffs.from_array(c).expand(lat=lat, lon=lon)


def check(name, text, folder):
    # The reference is scipy's own sum over the text's numbers: orthonormal with phase, sqrt(2) at m
    # > 0 taken out.
    reference_file = folder / "reference.txt"
    tool(
        "convert",
        text,
        reference_file,
        "--to-normalisation",
        "ortho",
        "--to-csphase",
        "-1",
        "--force",
    )
    rows = np.loadtxt(reference_file, delimiter=",", comments="#")
    lmax = int(rows[-1, 0])
    reference = np.zeros(len(THETA))
    for l, m, c, s in rows:
        y = sph_harm_y(int(l), int(m), THETA, PHI) * (1 if m == 0 else np.sqrt(2))
        reference += c * y.real + s * y.imag

    def compare(label, radii):
        apart = np.max(np.abs(radii / reference - 1))
        print(f"{name:<10} {label:<44} {apart:.1e}")
        assert apart <= TOLERANCE, label

    for normalisation in ["4pi", "ortho", "schmidt", "unnorm"]:
        for csphase in [1, -1]:
            flags = ["--to-normalisation", normalisation, "--to-csphase", csphase, "--force"]
            said = {"normalization": normalisation, "csphase": csphase}
            for extension, fmt in [
                ("txt", "shtools"),
                ("dov", "dov"),
                ("bshc", "bshc"),
                ("npy", "npy"),
            ]:
                path = folder / f"a.{extension}"
                tool("convert", text, path, *flags)
                read = pyshtools.SHCoeffs.from_file(str(path), format=fmt, **said)
                compare(f"pyshtools {fmt} {normalisation} csphase {csphase}", from_pyshtools(read))
    tool("convert", text, folder / "alm.npy", "--to", "alm", "--force")
    compare("ducc0 synthesis_general", from_ducc0(folder / "alm.npy", lmax))
    compare("healpy alm2map and scipy", from_healpy(folder / "alm.npy", lmax))
    tool("convert", text, folder / "a.coef", "--force")
    compare("SPHARM-PDM set by scipy", from_spharm_pdm(folder / "a.coef"))
    tool("convert", text, folder / "a.csv", "--force")
    compare("aics-shparam table by pyshtools", from_aics(folder / "a.csv"))
    tool("convert", text, folder / "a.tab", "--force")
    read = pyshtools.SHCoeffs.from_file(str(folder / "a.tab"), header=True, errors=True)
    compare("SHADR table by pyshtools", from_pyshtools(read))


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        fixture = ROOT / "tests/data/interop/pyshtools_4pi.npy"
        tool("convert", fixture, folder / "small.txt", "--normalisation", "4pi", "--csphase", "-1")
        tool("fit", ROOT / "data/head.obj", "-l", "32", "-o", folder / "head.txt")
        check("degree 12", folder / "small.txt", folder)
        check("head", folder / "head.txt", folder)


HARMOLUX = pathlib.Path(sys.argv[1]).resolve()
main()
