"""Harmolux beside ducc0 (and SHTns where installed), one thread, taking turns call by call; prints
medians and the quartiles of the ratio.

    cargo build --release --features experiments --example transform_speed
    python3 -m venv venv && . venv/bin/activate && pip install numpy ducc0
    # and shtns, which needs FFTW's headers
    OMP_NUM_THREADS=1 python benches/peers/transform.py [target/release/examples/transform_speed]

A ratio below 1 says that Harmolux is faster. Building the plan is timed apart: ducc0 tabulates its
recurrence in every call, SHTns and Harmolux once.
"""

import subprocess
import sys
import time

import ducc0
import numpy as np

try:
    import shtns
except ImportError:
    shtns = None

ours = subprocess.Popen(
    [sys.argv[1] if len(sys.argv) > 1 else "target/release/examples/transform_speed"],
    stdin=subprocess.PIPE,
    stdout=subprocess.PIPE,
    text=True,
)


def harmolux(task, lmax):
    ours.stdin.write(f"{task} {lmax}\n")
    ours.stdin.flush()
    return float(ours.stdout.readline())


def peer(call):
    start = time.perf_counter()
    call()
    return 1e6 * (time.perf_counter() - start)


def compare(name, lmax, task, call, turns, unit=1.0, sign="us"):
    harmolux(task, lmax), call()
    pairs = np.array([(harmolux(task, lmax), peer(call)) for _ in range(turns)])
    low, middle, high = np.quantile(pairs[:, 0] / pairs[:, 1], [0.25, 0.5, 0.75])
    mine, theirs = np.median(pairs, axis=0) / unit
    print(
        f"{task:9} {lmax:5}  harmolux {mine:9.1f} {sign}  {name} {theirs:9.1f} {sign}  ratio "
        f"{middle:.2f} ({low:.2f} to {high:.2f})",
        flush=True,
    )


def alm(lmax):
    rng = np.random.default_rng(0)
    size = (lmax + 1) * (lmax + 2) // 2
    values = rng.normal(size=size) + 1j * rng.normal(size=size)
    values[: lmax + 1] = values[: lmax + 1].real
    return values.reshape(1, -1)


for lmax in (32, 127, 255, 511, 1023):
    turns = 200 if lmax < 200 else 40 if lmax < 600 else 15
    settings = dict(lmax=lmax, mmax=lmax, spin=0, geometry="GL", nthreads=1)
    series, rings, azimuths = alm(lmax), lmax + 1, 2 * lmax + 2
    grid = ducc0.sht.synthesis_2d(alm=series, ntheta=rings, nphi=azimuths, **settings)
    print(
        f"plan      {lmax:5}  harmolux "
        f"{np.median([harmolux('plan', lmax) for _ in range(9)]):9.1f} us"
    )
    compare(
        "ducc0",
        lmax,
        "synthesis",
        lambda: ducc0.sht.synthesis_2d(alm=series, ntheta=rings, nphi=azimuths, **settings),
        turns,
    )
    compare("ducc0", lmax, "analysis", lambda: ducc0.sht.analysis_2d(map=grid, **settings), turns)
    if shtns:
        s = shtns.sht(lmax, lmax)
        s.set_grid(rings, azimuths)
        spectrum = s.spec_array()
        spectrum[:] = series[0]
        field = s.synth(spectrum)
        compare("SHTns", lmax, "synthesis", lambda: s.synth(spectrum), turns)
        compare("SHTns", lmax, "analysis", lambda: s.analys(field.copy()), turns)

for lmax in (8, 16, 32, 64, 128):
    n = 100_000
    rng = np.random.default_rng(2)
    points = np.stack([np.arccos(rng.uniform(-1, 1, n)), rng.uniform(0, 2 * np.pi, n)], 1)
    settings = dict(alm=alm(lmax), lmax=lmax, mmax=lmax, loc=points, epsilon=1e-10, nthreads=1)

    def value():
        ducc0.sht.synthesis_general(spin=0, **settings)

    def value_and_gradient():
        value()
        ducc0.sht.synthesis_general(spin=1, mode="DERIV1", **settings)

    compare("ducc0", lmax, "values", value, 9, unit=n / 1e3, sign="ns a point")
    compare("ducc0", lmax, "jets", value_and_gradient, 9, unit=n / 1e3, sign="ns a point")
