"""Whether this processor can run the native part, asked before that is loaded.

On x86-64 it is compiled for the level v3 (AVX2, FMA, BMI2), all of it, what Python calls first
included: on an older processor the very first call may be an illegal instruction. So the processor
is asked by others: numpy, which asks it itself, and the system.
"""

from __future__ import annotations

import os
import sys

#: What of the level v3 the system calls so, in the first lines of /proc/cpuinfo.
FLAGS = frozenset({"avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "movbe"})
#: What of it numpy calls so.
FEATURES = ("AVX2", "FMA3", "F16C")
#: What a build that needs it would say, which no other holds.
NEEDS = b"this build of sunstone needs a processor with AVX2"


def refusal(flags: frozenset[str] | None, features: dict[str, bool]) -> str | None:
    """What to say to a processor of these flags (None if unknown) and features, if it lacks any."""
    missing = set() if flags is None else set(FLAGS - flags)
    missing.update(name.lower() for name in FEATURES if not features.get(name, True))
    if not missing:
        return None
    return (
        "this build of sunstone needs a processor with AVX2, FMA and BMI2 (x86-64-v3: Intel since "
        "Haswell 2013, AMD since Zen 2017), and this one lacks "
        + ", ".join(sorted(missing))
        + ".\n"
        'To build for this processor: RUSTFLAGS="-C target-cpu=native" pip install . in the source'
    )


def flags_of(text: str) -> frozenset[str] | None:
    """The flags of the first processor in the text of /proc/cpuinfo."""
    for line in text.splitlines():
        name, _, value = line.partition(":")
        if name.strip() == "flags":
            return frozenset(value.split())
    return None


def check() -> None:
    """Raises ImportError where the native part cannot run."""
    machine = os.uname().machine if hasattr(os, "uname") else ""
    if machine.lower() not in ("x86_64", "amd64"):
        return
    text = refusal(_flags(), _features())
    if text is not None and _is_needed():
        raise ImportError(text)


def _flags() -> frozenset[str] | None:
    try:
        file = os.open("/proc/cpuinfo", os.O_RDONLY | os.O_CLOEXEC)
    except (OSError, AttributeError):
        return None
    try:
        # One processor is enough, and many take the system long to list.
        return flags_of(os.read(file, 8192).decode("ascii", "replace"))
    except OSError:
        return None
    finally:
        os.close(file)


def _features() -> dict[str, bool]:
    for name in ("numpy._core._multiarray_umath", "numpy.core._multiarray_umath"):
        features = getattr(sys.modules.get(name), "__cpu_features__", None)
        if features:
            return dict(features)
    return {}


def _is_needed() -> bool:
    """Whether the native part was compiled for more than this processor has."""
    import mmap  # Hardly anybody comes here.

    folder = os.path.dirname(os.path.abspath(__file__))
    for name in os.listdir(folder):
        if name.startswith("_sunstone.") and not name.endswith(".pyi"):
            with open(os.path.join(folder, name), "rb") as file:
                with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
                    return content.find(NEEDS) >= 0
    return False
