"""Writes films.csv: films on metals and dielectrics by PyPI's tmm 0.2.0 (MIT), S. J. Byrnes.

tmm has n + i k and exp(-i w t), fields along the interface, and p with the sign opposite to
Verdet's in reflection. Rows of Mueller matrices are those of the convention in
src/polarization/mod.rs: R01 = (Rs - Rp) / 2, C + i S = r_p conj(r_s) with phasors exp(+i w t).
"""

import csv
import math

import numpy as np
from tmm import coh_tmm

LAYERS = [
    # before, film, behind
    (1.0, 1.38 + 0j, 1.52 + 0j),
    (1.52, 1.38 + 0j, 1.0 + 0j),
    (1.0, 2.4 + 0j, 1.5 + 0j),
    (1.5, 2.4 + 0j, 1.0 + 0j),
    (1.5, 1.1 + 0j, 1.8 + 0j),
    (1.33, 1.0 + 0j, 1.33 + 0j),
    (1.0, 1.46 + 0j, 0.963 + 6.7j),
    (1.0, 2.2 + 0.03j, 0.16 + 3.15j),
    (1.0, 1.9 + 0.8j, 2.9 + 3.0j),
]
WAVES = [0.0, 0.02, 0.18, 0.5, 1.3, 7.25]
ANGLES_DEG = [0.0, 20.0, 45.0, 60.0, 80.0, 89.0]


def fields(n0, n1, n2, waves, deg, polarization):
    angle = math.radians(deg)
    thickness = [np.inf, waves, np.inf]
    return coh_tmm(polarization, [n0, n1, n2], thickness, angle, 1.0)


with open("films.csv", "w", newline="") as file:
    rows = csv.writer(file, lineterminator="\n")
    names = "before eta k behind behind_k waves angle_deg R00 R01 R22 R32 T00 T01 T22 T32"
    rows.writerow(names.split())
    for n0, n1, n2 in LAYERS:
        for waves in WAVES:
            for deg in ANGLES_DEG:
                s, p = (fields(n0, n1, n2, waves, deg, of) for of in "sp")
                # Verdet's sign of r_p is that of tmm's: both are the opposite of r_s straight on.
                product = np.conj(p["r"] * np.conj(s["r"]))
                check = fields(n0, n1, n2, waves, 0.0, "p")["r"] + fields(n0, n1, n2, waves, 0.0, "s")["r"]
                assert abs(check) < 1e-12
                size = math.sqrt(max(p["T"] * s["T"], 0.0))
                through = np.conj(p["t"] * np.conj(s["t"]))
                through = through / abs(through) * size if size > 0.0 else 0j
                found = [(s["R"] + p["R"]) / 2, (s["R"] - p["R"]) / 2, product.real, product.imag]
                found += [(s["T"] + p["T"]) / 2, (s["T"] - p["T"]) / 2, through.real, through.imag]
                media = [n0, n1.real, n1.imag, n2.real, n2.imag, waves, deg]
                rows.writerow([repr(float(value)) for value in media + found])
