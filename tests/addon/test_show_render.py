"""The result of a spectral render as an image in Blender, and the settings of what is written."""

from pathlib import Path

import bpy
import numpy as np
import pytest

from spectral_probe.files.image_exr import write_rgb


def written(path: Path, value: float, space: object) -> Path:
    image = np.full((4, 6, 3), value, np.float32)
    write_rgb(path, image, header={"chromaticities": space.chromaticities})
    return path


@pytest.mark.usefixtures("scene")
@pytest.mark.parametrize("name", ["Linear Rec.709", "Linear Rec.2020", "ACEScg"])
def test_the_render_keeps_its_floats_in_the_working_space(in_extension, tmp_path, name):
    pictures = in_extension("operators.pictures")
    spaces = in_extension("spectral_probe.spectra.working_space")
    matrix = in_extension("operators.bridge.materials").working_to_rec709
    bpy.ops.wm.set_working_color_space(working_space=name)
    space = spaces.working_space(matrix())
    assert space.name == name
    for value in (7.5, -0.25):  # the second render replaces the first
        image = pictures.show_render(written(tmp_path / f"{value}.exr", value, space))
        assert image.name == "Spectral Render"
        assert image.use_view_as_render
        assert not image.packed_files
        pixels = np.empty(4 * 6 * 4, np.float32)
        image.pixels.foreach_get(pixels)
        assert pixels[0] == pytest.approx(value, rel=1e-4)
        assert image.colorspace_settings.name == name
    assert len([block for block in bpy.data.images if block.name.startswith("Spectral Render")]) == 1


def test_output_settings_are_those_of_the_panel(settings, in_extension):
    read = in_extension("operators.settings_output").output_settings_from
    output = settings.output
    assert read(output).white is None
    assert read(output).denoise is None
    output.spectral, output.adapt, output.white, output.denoise = True, True, "A", "OFF"
    given = read(output)
    assert given.spectral
    assert given.white.stated == "A"
    assert given.denoise is False
    output.white = "blue"
    with pytest.raises(in_extension("spectral_probe.errors").SpectralDataError, match="no white called"):
        read(output)
