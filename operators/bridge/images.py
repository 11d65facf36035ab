"""Pixels of image datablocks."""

from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ...spectral_probe.errors import FileFormatError


def pixels_of(image: bpy.types.Image) -> np.ndarray[Any, np.dtype[np.float32]]:
    """Pixels (H, W, channels) of an image datablock, row 0 the image's top (Blender's is the lowest).

    Raises
    ------
    FileFormatError
        If it has no pixels, since its file is gone.
    """
    width, height = image.size
    if not width or not height:
        raise FileFormatError(f"The image {image.name} has no pixels. Choose another, or find its file.")
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(height, width, image.channels)[::-1]


def transparent_copy(picture: Path, name: str) -> bpy.types.Image:
    """A new image datablock with the colours of a picture file, all of it transparent, packed into the .blend.

    Raises
    ------
    FileFormatError
        If there is no such picture.
    """
    if not picture.is_file():
        raise FileFormatError(f"There is no picture {picture}. Build the probe again.")
    source = bpy.data.images.load(str(picture))
    try:
        pixels = np.ones((*source.size[::-1], 4), np.float32)
        own = pixels_of(source)[::-1]
        pixels[..., : min(own.shape[2], 3)] = own[..., :3]
    finally:
        bpy.data.images.remove(source)
    pixels[..., 3] = 0.0
    image = bpy.data.images.new(name, pixels.shape[1], pixels.shape[0], alpha=True)
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    image.pack()
    return image
