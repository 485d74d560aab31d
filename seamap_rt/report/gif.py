"""Frames → an animated GIF that plays over and over."""

from __future__ import annotations

import io
from collections.abc import Sequence

from PIL import Image


def gif(frames: Sequence[Image.Image], milliseconds: Sequence[int], colours: int = 256) -> bytes:
    """A GIF of RGB frames, each shown so long. One palette, the first frame's, and no dithering: still parts stay
    still, and the file small."""
    palette = frames[0].quantize(colours, method=Image.Quantize.MEDIANCUT, kmeans=2)
    indexed = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    buffer = io.BytesIO()
    indexed[0].save(
        buffer, "GIF", save_all=True, append_images=indexed[1:], duration=list(milliseconds), loop=0, optimize=False
    )
    return buffer.getvalue()
