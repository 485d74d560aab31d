"""Where work is done: on the processor, or on the device that Dr.Jit has. The environment says so.

    SEAMAP_RT_ECHOES   processor or device: facets, light, echoes, truth, and what the retrieval takes from the voltages
    SEAMAP_RT_SEA      processor or device: the sea's splines
    SEAMAP_RT_SEA_FFT  processor or device: the FFTs that make the coefficients of splines which are on the device

Left out, the first is the processor, and the second goes with it where the device is a graphics processor: on LLVM the
splines would be evaluated by the same cores, and slower. So it is with the third, where there is an array library for
that graphics processor; without one the coefficients are made here, and go up.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from ..errors import InputError, NoBackend

ECHOES, SEA, SEA_FFT = "SEAMAP_RT_ECHOES", "SEAMAP_RT_SEA", "SEAMAP_RT_SEA_FFT"

if TYPE_CHECKING:
    from .array_library import ArrayLibrary


def echoes_on_device() -> bool:
    """Whether the device is asked for. Raises InputError for a word that is neither."""
    return _word(ECHOES, "processor") == "device"


def sea_on_device() -> bool:
    """Whether the sea is to be evaluated there. Raises InputError for a word that is neither."""
    word = _word(SEA, "")
    return word == "device" or (not word and echoes_on_device() and _is_graphics_processor())


def library_for_sea() -> ArrayLibrary | None:
    """What makes the FFTs of a sea that is evaluated there on the device too; None: they are the host's. Raises
    InputError for a word that is neither, and NoBackend where the device is asked for and nothing makes them there."""
    word = _word(SEA_FFT, "")
    if word == "processor" or not (word or _is_graphics_processor()):
        return None
    from .array_library import array_library

    library = array_library()
    if not isinstance(library, str):
        return library
    if word:
        raise NoBackend(f"{SEA_FFT} = {word}: {library}; or leave {SEA_FFT} out")
    return None


def _word(variable: str, otherwise: str) -> str:
    word = os.environ.get(variable, otherwise)
    if word not in ("processor", "device", otherwise):
        raise InputError(f"{variable} = {word}: must be processor or device; correct the environment")
    return word


def _is_graphics_processor() -> bool:
    from .backend import prepare

    return prepare().kind == "cuda"
