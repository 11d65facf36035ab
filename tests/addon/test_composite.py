"""The composite from Blender: what the verb gives, shown and remembered."""

import bpy
import cv2
import numpy as np
import pytest

ops = bpy.ops.spectral_probe
SIZE = 24


@pytest.fixture
def rendered(settings, tmp_path, in_extension):
    """A render of a white square on grey ground, chosen in the scene; and its plate, a picture of that ground."""
    write_channels = in_extension("spectral_probe.files.image_exr").write_channels
    coverage = in_extension("spectral_probe.composite_model").ObjectCoverage
    cover = np.zeros((SIZE, SIZE), np.float32)
    cover[8:14, 8:14] = 1
    whole = np.ones_like(cover)
    for folder, level in ((tmp_path, np.maximum(cover, 0.5)), (tmp_path / "without", 0.5 * whole)):
        write_channels(folder / "xyz.exr", dict.fromkeys("XYZ", level) | {"A": whole})
        write_channels(folder / "rgb.exr", dict.fromkeys("RGB", level))
    in_extension("spectral_probe.files.objects_exr").write_objects(
        tmp_path / "objects.exr", coverage({"square": cover}, cover, 1 - cover)
    )
    plate = tmp_path / "plate.png"
    assert cv2.imwrite(str(plate), np.full((SIZE, SIZE, 3), 188, np.uint8))
    settings.render_directory, settings.composite.plate = str(tmp_path), str(plate)
    return tmp_path


def test_composite_gives_what_the_function_gives(rendered, settings, in_extension):
    settings.composite.srgb, settings.composite.show = True, "composite_rgb"
    assert ops.composite() == {"FINISHED"}
    module = in_extension("spectral_probe.composite.composite")
    plate = in_extension("spectral_probe.composite.plate_photo").PlateSettings(response="srgb")
    numbers = in_extension("spectral_probe.model").finish(
        module.composite(
            rendered, rendered / "plate.png", rendered / "function", module.CompositeSettings(plate)
        )
    )
    own, function = ((rendered / name / "composite.exr").read_bytes() for name in ("composite", "function"))
    assert own == function
    assert settings.composite.changed_fraction == pytest.approx(numbers["changed_fraction"])
    assert settings.composite.changed_fraction == pytest.approx(36 / SIZE**2)
    shown = bpy.data.images["Spectral Probe Composite"]
    assert shown.filepath.endswith("composite_rgb.png")


def test_a_missing_response_is_said(rendered):  # noqa: ARG001  (chosen in the scene)
    with pytest.raises(RuntimeError, match="response curve is missing"):
        ops.composite()


def test_a_missing_photograph_is_said(rendered, settings):  # noqa: ARG001  (chosen in the scene)
    settings.composite.plate = ""
    with pytest.raises(RuntimeError, match="no backplate"):
        ops.composite()


def test_a_grey_button_says_why(rendered, settings):
    settings.composite.background = "PROBE"
    with pytest.raises(RuntimeError, match="Build the probe first"):
        ops.composite()
    (rendered / "xyz.exr").unlink()
    with pytest.raises(RuntimeError, match="Render the scene spectrally first"):
        ops.composite()
