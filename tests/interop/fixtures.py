"""Write the small files of tests/data/interop by the packages themselves, with radii that these
packages compute.

    python3 -m venv venv && venv/bin/pip install -r tests/interop/requirements.txt
    venv/bin/python tests/interop/fixtures.py

One shape of degree 12, about 0.09 m, in every convention; only the table of aics-shparam has shapes
of its own, found in images. radii.json holds for each file [latitude, longitude in degrees, radius]
at a few directions, the poles among them.
"""

import csv
import json
import pathlib

import ducc0
import healpy
import numpy as np
import pyshtools
from aicsshparam import shparam
from scipy.special import sph_harm_y

LMAX = 12
DIRECTIONS = [
    (90, 0),
    (-90, 0),
    (0, 0),
    (0, 180),
    (17, -63.5),
    (-30, 200),
    (89.999, 77),
    (45, 90),
    (-72.25, 301),
]
FOLDER = pathlib.Path(__file__).parent.parent / "data" / "interop"


def shape():
    """The coefficients that all files hold: 4pi, csphase 1."""
    random = np.random.default_rng(12)
    c = np.zeros((2, LMAX + 1, LMAX + 1))
    c[0, 0, 0] = 0.09
    for l in range(1, LMAX + 1):
        for m in range(l + 1):
            c[0, l, m] = random.normal() * 0.02 / (1 + l) ** 2
            if m > 0:
                c[1, l, m] = random.normal() * 0.02 / (1 + l) ** 2
    return pyshtools.SHCoeffs.from_array(c)


def radii(coefficients):
    return [
        [lat, lon, float(coefficients.expand(lat=float(lat), lon=float(lon)))]
        for lat, lon in DIRECTIONS
    ]


def radians():
    lat, lon = np.radians(np.array(DIRECTIONS, dtype=float)).T
    return np.pi / 2 - lat, np.mod(lon, 2 * np.pi)


def write_pyshtools(coefficients):
    found = {}
    for name, fmt, normalization, csphase in [
        ("pyshtools_ortho.sh", "shtools", "ortho", -1),
        ("pyshtools_schmidt.dov", "dov", "schmidt", 1),
        ("pyshtools_unnorm.bshc", "bshc", "unnorm", 1),
        ("pyshtools_4pi.npy", "npy", "4pi", -1),
    ]:
        converted = coefficients.convert(normalization=normalization, csphase=csphase)
        if fmt == "shtools":
            # With a header line, and with columns of errors.
            errors = np.abs(converted.coeffs) * 1e-3
            converted = pyshtools.SHCoeffs.from_array(
                converted.coeffs,
                normalization=normalization,
                csphase=csphase,
                errors=errors,
                error_kind="formal",
            )
            converted.to_file(FOLDER / name, header="0.09, 0.0, 0.0, 12.0", errors=True)
        else:
            converted.to_file(str(FOLDER / name), format=fmt)
        found[name] = radii(converted)
    return found


def write_alm(coefficients):
    """healpy and ducc0 get samples and find a_lm themselves: no factor of ours enters."""
    found = {}
    theta, phi = radians()
    nodes, azimuths = LMAX + 1, 2 * LMAX + 2
    cosines = np.polynomial.legendre.leggauss(nodes)[0][::-1]
    lat = np.degrees(np.pi / 2 - np.arccos(cosines))
    lon = np.arange(azimuths) * 360.0 / azimuths
    samples = np.array([[coefficients.expand(lat=a, lon=o) for o in lon] for a in lat])
    alm = ducc0.sht.analysis_2d(map=samples[None], lmax=LMAX, spin=0, geometry="GL")
    np.save(FOLDER / "ducc0_alm.npy", alm)
    at = np.stack([theta, phi], axis=1)
    values = ducc0.sht.synthesis_general(alm=alm, spin=0, lmax=LMAX, loc=at, epsilon=1e-13)[0]
    found["ducc0_alm.npy"] = [[*d, float(v)] for d, v in zip(DIRECTIONS, values)]
    # healpy's own index of each degree and order.
    triangle = np.zeros(healpy.Alm.getsize(LMAX), dtype=np.complex128)
    for l in range(LMAX + 1):
        for m in range(l + 1):
            triangle[healpy.Alm.getidx(LMAX, l, m)] = alm[0, ducc0_index(l, m)]
    healpy_map = healpy.alm2map(triangle, 64, lmax=LMAX)
    triangle = healpy.map2alm(healpy_map, lmax=LMAX, iter=20)
    np.save(FOLDER / "healpy_alm.npy", triangle)
    # The centres of its pixels are where healpy gives values.
    again = healpy.alm2map(triangle, 64, lmax=LMAX)
    pixels = [0, 1000, 20000, 49151]
    places = [healpy.pix2ang(64, p, lonlat=True)[::-1] for p in pixels]
    found["healpy_alm.npy"] = [
        [float(a), float(o), float(again[p])] for (a, o), p in zip(places, pixels)
    ]
    return found


def ducc0_index(l, m):
    return m * (2 * LMAX + 1 - m) // 2 + l


def write_spharm_pdm(coefficients):
    """SPHARM-PDM's text with its six decimals, in millimetres; the set is projected on scipy's
    harmonics by quadrature."""
    degree = LMAX + 1
    nodes, weights = np.polynomial.legendre.leggauss(degree + 2)
    theta = np.arccos(nodes)
    phi = np.arange(2 * degree + 4) * 2 * np.pi / (2 * degree + 4)
    theta, phi = np.meshgrid(theta, phi, indexing="ij")
    weight = np.broadcast_to(weights[:, None], theta.shape) * 2 * np.pi / phi.shape[1]
    lat, lon = np.degrees(np.pi / 2 - theta), np.degrees(phi)
    r = 1000 * np.array(
        [coefficients.expand(lat=a, lon=o) for a, o in zip(lat.ravel(), lon.ravel())]
    )
    r = r.reshape(theta.shape)
    centre = np.array([10.0, -20.0, 30.0])
    omega = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
    points = centre[:, None, None] + r * omega
    rows = []
    for l in range(degree + 1):
        for m in range(l + 1):
            integral = np.sum(points * np.conj(sph_harm_y(l, m, theta, phi)) * weight, axis=(1, 2))
            if m == 0:
                rows.append(integral.real)
            else:
                # x = sum_m>=0 (C cos + S sin) |Y|: C - iS = 2 <x, Y>.
                rows.extend([2 * integral.real, -2 * integral.imag])
    body = ",\n".join("{%.6f, %.6f, %.6f}" % tuple(row) for row in rows)
    (FOLDER / "spharm_pdm_mm.coef").write_text("{ %d,%s}" % (len(rows), body))
    return {"spharm_pdm_mm.coef": radii(coefficients)}


def write_aics():
    """Two pears of voxels, thick towards +x and +y, expanded by aics-shparam; radii by pyshtools at
    the longitude of that package."""
    rows = []
    for bend in [0.0, 0.3]:
        z, y, x = (np.indices((48, 48, 48)) - 23.5) / 20
        blob = (y - bend * x**2) ** 2 + 1.5 * z**2 < 0.4 * (1 - x**2) * (1 + 0.8 * x)
        (values, _), _ = shparam.get_shcoeffs(
            image=blob.astype(np.uint8), lmax=8, alignment_2d=False
        )
        rows.append(values)
    with open(FOLDER / "aicsshparam.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, ["CellId", *rows[0]])
        writer.writeheader()
        for number, row in enumerate(rows):
            writer.writerow({"CellId": number + 1, **{k: repr(float(v)) for k, v in row.items()}})
    found = {}
    for number, row in enumerate(rows):
        c = np.zeros((2, 9, 9))
        for l in range(9):
            for m in range(9):
                c[0, l, m], c[1, l, m] = row[f"shcoeffs_L{l}M{m}C"], row[f"shcoeffs_L{l}M{m}S"]
        values = pyshtools.SHCoeffs.from_array(c)
        found[f"aicsshparam.csv:{number + 1}"] = [
            [lat, lon, float(values.expand(lat=float(lat), lon=lon + 180.0))]
            for lat, lon in DIRECTIONS
        ]
    return found


def write_shadr(coefficients):
    """A record as the Planetary Data System defines it, kilometres; read back by pyshtools as a
    table with a header."""
    real = "{:23.16E}".format
    lines = [
        ",".join(
            [
                real(0.00009),
                real(0),
                real(0),
                *["%5d" % v for v in (LMAX, LMAX, 1)],
                real(0),
                real(0),
            ]
        )
    ]
    lines[0] += "," + " " * 105
    for l in range(LMAX + 1):
        for m in range(l + 1):
            c, s = coefficients.coeffs[:, l, m] / 1000
            lines.append(
                ",".join(["%5d" % l, "%5d" % m, real(c), real(s), real(1e-9), real(1e-9)])
                + ", "
                + " " * 12
            )
    path = FOLDER / "shadr_km.tab"
    path.write_bytes(("\r\n".join(lines) + "\r\n").encode())
    back = pyshtools.SHCoeffs.from_file(path, header=True, errors=True)
    return {"shadr_km.tab": [[lat, lon, 1000 * r] for lat, lon, r in radii(back)]}


def main():
    FOLDER.mkdir(exist_ok=True)
    coefficients = shape()
    found = write_pyshtools(coefficients)
    found |= write_alm(coefficients)
    found |= write_spharm_pdm(coefficients)
    found |= write_aics()
    found |= write_shadr(coefficients)
    lines = [f" {json.dumps(name)}: {json.dumps(values)}" for name, values in found.items()]
    (FOLDER / "radii.json").write_text("{\n" + ",\n".join(lines) + "\n}\n")


main()
