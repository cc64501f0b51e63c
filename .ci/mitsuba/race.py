"""Races Mitsuba's polarized path tracer on its models of surfaces: how many times as fast Sunstone is.

    python race.py --data CHECKOUT [--sunstone PROGRAM] [--runs N] [--spp N] [-o TABLE] [MODEL...]

Both read the same XML: a ball on a ground under an even sky and a lamp, which are analytic shapes,
and matpreview of the public repository mitsuba-renderer/mitsuba-data, a mesh under an environment
map, each with one of the models. Mitsuba renders as llvm_ad_spectral_polarized, which carries four
wavelengths, and so does Sunstone. Times are of rendering alone, after Mitsuba has compiled its
kernel; renders of both alternate. Columns:

    speed       Mitsuba's seconds over ours for as many samples
    efficiency  the same times the ratio of the variances of S0: seconds to the same error

Variances are of pixels over their squared means, without the hundredth of the pixels that have the
greatest.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

MODELS = {
    "diffuse": '<bsdf type="diffuse" ID><rgb name="reflectance" value="0.5, 0.4, 0.3"/></bsdf>',
    "conductor": '<bsdf type="conductor" ID><string name="material" value="Au"/></bsdf>',
    "dielectric": '<bsdf type="dielectric" ID><float name="int_ior" value="1.5"/></bsdf>',
    "thindielectric": '<bsdf type="thindielectric" ID><float name="int_ior" value="1.5"/></bsdf>',
    "roughconductor": '<bsdf type="roughconductor" ID><string name="material" value="Cu"/>'
                      '<string name="distribution" value="ggx"/>'
                      '<float name="alpha" value="0.2"/></bsdf>',
    "roughdielectric": '<bsdf type="roughdielectric" ID><float name="int_ior" value="1.5"/>'
                       '<string name="distribution" value="ggx"/>'
                       '<float name="alpha" value="0.2"/></bsdf>',
    "pplastic": '<bsdf type="pplastic" ID><rgb name="diffuse_reflectance" value="0.2, 0.3, 0.5"/>'
                '<float name="alpha" value="0.1"/></bsdf>',
    "blendbsdf": '<bsdf type="blendbsdf" ID><float name="weight" value="0.5"/>'
                 '<bsdf type="diffuse"/><bsdf type="roughconductor">'
                 '<string name="material" value="Al"/><float name="alpha" value="0.3"/></bsdf></bsdf>',
    "twosided": '<bsdf type="twosided" ID><bsdf type="diffuse"/></bsdf>',
    "polarizer": '<bsdf type="polarizer" ID><float name="theta" value="30"/></bsdf>',
    "retarder": '<bsdf type="retarder" ID><float name="delta" value="90"/></bsdf>',
}

BALL = """<scene version="3.0.0">
<default name="spp" value="64"/><default name="width" value="512"/>
<default name="height" value="512"/>
<integrator type="path"><integer name="max_depth" value="12"/></integrator>
<sensor type="perspective"><float name="fov" value="35"/>
<transform name="to_world"><lookat origin="0, -6, 3" target="0, 0, 0.8" up="0, 0, 1"/></transform>
<sampler type="independent"><integer name="sample_count" value="$spp"/></sampler>
<film type="hdrfilm"><integer name="width" value="$width"/>
<integer name="height" value="$height"/><rfilter type="box"/></film></sensor>
<emitter type="constant"><rgb name="radiance" value="0.4, 0.5, 0.6"/></emitter>
<shape type="rectangle"><transform name="to_world"><scale value="0.7"/>
<lookat origin="3, -2, 4" target="0, 0, 1" up="0, 0, 1"/></transform>
<emitter type="area"><rgb name="radiance" value="12, 11, 10"/></emitter></shape>
<shape type="rectangle"><transform name="to_world"><scale value="8"/></transform>
<bsdf type="diffuse"><rgb name="reflectance" value="0.4, 0.4, 0.4"/></bsdf></shape>
<shape type="sphere"><point name="center" x="0" y="0" z="1"/><float name="radius" value="1"/>
MODEL</shape></scene>
"""

MITSUBA = """
import sys
import time
import mitsuba as mi
import numpy as np
mi.set_variant("llvm_ad_spectral_polarized")
import drjit as dr
scene = mi.load_file(sys.argv[1])
spp = int(sys.argv[2])
def image(seed):
    start = time.monotonic()
    image = mi.render(scene, spp=spp, seed=seed)
    dr.eval(image)
    dr.sync_thread()
    return time.monotonic() - start, np.array(image)[:, :, :3]
image(0)
print("ready", flush=True)
for line in sys.stdin:
    seconds, found = image(int(line))
    np.save(sys.argv[3], found)
    print(seconds, flush=True)
"""


def bed(name, model, data, folder):
    """The path of a scene with a model."""
    if name == "ball":
        text = BALL.replace("MODEL", model.replace(" ID", ""))
    else:
        source = data / "scenes/matpreview"
        text = (source / "matpreview.xml").read_text()
        start = text.index('<bsdf type="plastic" id="bsdf-matpreview">')
        end = text.index("</bsdf>", start) + len("</bsdf>")
        text = text[:start] + model.replace("ID", 'id="bsdf-matpreview"') + text[end:]
        text = text.replace('name="max_depth" value="-1"', 'name="max_depth" value="12"')
        for file in source.iterdir():
            if file.suffix != ".xml" and not (folder / file.name).exists():
                (folder / file.name).symlink_to(file.resolve())
    path = folder / f"{name}.xml"
    path.write_text(text)
    return path


def render_ours(program, path, spp, seed, out):
    """Our seconds from start to file."""
    command = [program, "render", path, "-o", out, "--mode", "polarized", "--color", "spectral",
               "--wavelengths", "4", "--spp", str(spp), "--seed", str(seed), "--quiet",
               "--allow-outside"]
    start = time.monotonic()
    subprocess.run(command, check=True, capture_output=True,
                   env={**os.environ, "SUNSTONE_CACHE": "off"})
    return time.monotonic() - start


def read(path):
    """S0 in RGB."""
    import mitsuba as mi
    mi.set_variant("scalar_rgb")
    bitmap = mi.Bitmap(str(path))
    names = [field.name for field in bitmap.struct_()]
    return np.array(bitmap, dtype=np.float32)[:, :, [names.index(name) for name in "RGB"]]


def noise(images):
    """The mean over pixels of variance over squared mean."""
    images = np.stack(images).mean(axis=-1)
    mean = images.mean(axis=0)
    lit = mean > 1e-3
    relative = (images.var(axis=0, ddof=1)[lit] / mean[lit] ** 2)
    return float(np.sort(relative)[:int(0.99 * relative.size)].mean())


def raced(arguments, path, folder):
    """Speed and efficiency, and the ratio of the means of both images."""
    kept, out = folder / "theirs.npy", folder / "ours.exr"
    command = [sys.executable, "-c", MITSUBA, str(path), str(arguments.spp), str(kept)]
    theirs = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                              cwd=folder)
    if theirs.stdout.readline().strip() != "ready":
        return ["Mitsuba fails"] + ["-"] * 4
    start = min(render_ours(arguments.sunstone, path, 1, 1, out) for _ in range(2))
    seconds, images = ([], []), ([], [])
    for seed in range(1, arguments.runs + 1):
        print(seed, file=theirs.stdin, flush=True)
        seconds[0].append(float(theirs.stdout.readline()))
        images[0].append(np.load(kept))
        whole = render_ours(arguments.sunstone, path, arguments.spp, seed, out)
        seconds[1].append((whole - start) * arguments.spp / (arguments.spp - 1))
        images[1].append(read(out))
    theirs.stdin.close()
    theirs.wait()
    speed = min(seconds[0]) / min(seconds[1])
    efficiency = speed * noise(images[0]) / noise(images[1])
    means = np.mean(images[1]) / np.mean(images[0])
    return [f"{min(seconds[0]):.2f}", f"{min(seconds[1]):.2f}", f"{speed:.2f}",
            f"{efficiency:.2f}", f"{means:.3f}"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("models", nargs="*")
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--sunstone", default="sunstone")
    parser.add_argument("--runs", type=int, default=4)
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("-o", "--output", type=Path)
    arguments = parser.parse_args()
    rows = [["scene", "model", "Mitsuba, s", "ours, s", "speed", "efficiency", "means"]]
    for name in ("ball", "matpreview"):
        for model in arguments.models or MODELS:
            with tempfile.TemporaryDirectory() as scratch:
                folder = Path(scratch)
                path = bed(name, MODELS[model], arguments.data.resolve(), folder)
                rows.append([name, model, *raced(arguments, path, folder)])
                print("\t".join(rows[-1]), flush=True)
    if arguments.output:
        arguments.output.write_text("\n".join("\t".join(row) for row in rows) + "\n")


if __name__ == "__main__":
    main()
