"""Where work is done: on the processor, or on the device that Dr.Jit has. The environment says so.

    SEAMAP_RT_ECHOES   processor or device: facets, light, echoes, truth, and what the retrieval takes from the voltages
    SEAMAP_RT_SEA      processor or device: the sea's splines

Left out, the first is the processor, and the second goes with it where the device is a graphics processor: on LLVM the
splines would be evaluated by the same cores, and slower.
"""

from __future__ import annotations

import os

from ..errors import InputError

ECHOES, SEA = "SEAMAP_RT_ECHOES", "SEAMAP_RT_SEA"


def echoes_on_device() -> bool:
    """Whether the device is asked for. Raises InputError for a word that is neither."""
    return _word(ECHOES, "processor") == "device"


def sea_on_device() -> bool:
    """Whether the sea is to be evaluated there. Raises InputError for a word that is neither."""
    word = _word(SEA, "")
    return word == "device" or (not word and echoes_on_device() and _is_graphics_processor())


def _word(variable: str, otherwise: str) -> str:
    word = os.environ.get(variable, otherwise)
    if word not in ("processor", "device", otherwise):
        raise InputError(f"{variable} = {word}: must be processor or device; correct the environment")
    return word


def _is_graphics_processor() -> bool:
    from .backend import prepare

    return prepare().kind == "cuda"
