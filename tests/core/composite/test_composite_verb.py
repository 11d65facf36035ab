"""The verb `composite` on folders as a render leaves them."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from spectral_probe.cli import main
from spectral_probe.composite.backplate_file import save_backplate
from spectral_probe.composite.distortion import Lens
from spectral_probe.composite_model import Backplate, ObjectCoverage
from spectral_probe.files.image_exr import read_channels, read_rgb, write_channels, write_rgb
from spectral_probe.files.objects_exr import write_objects
from spectral_probe.geometry.camera import pixel_rays
from spectral_probe.model import Camera
from spectral_probe.photo.read import srgb_to_linear
from spectral_probe.photo.response import KNOTS
from spectral_probe.render.outputs import DENOISED_NOTE, picture_header, picture_rgb
from spectral_probe.render.pass_folder import PassFolder, digest_of, render_steps
from spectral_probe.render.plan import reference_plan
from spectral_probe.render.plan_file import save_plan
from spectral_probe.spectra.camera import camera_sensitivities
from spectral_probe.spectra.colorimetry import rec709_to_xyz, spectra_to_xyz, xyz_to_rec709
from spectral_probe.spectra.grid import STEP_NM
from spectral_probe.spectra.working_space import working_space

SIZE = 40
NIKON = "Nikon 5100 (NPL)"


def scene():
    """A white square on a grey ground, and its shadow; (H, W) factors of the ground's radiance, and the square's coverage."""
    cover = np.zeros((SIZE, SIZE), np.float32)
    cover[10:20, 10:20] = 1
    cover[9, 10:20] = 0.5
    light = np.ones((SIZE, SIZE), np.float32)
    light[10:20, 20:26] = 0.4
    return cover, light


def write_part(folder, image, alpha, rgb=True):
    """xyz.exr and rgb.exr of scene-linear Rec.709 (H, W, 3)."""
    planes = dict(zip("XYZ", np.moveaxis(rec709_to_xyz(image), -1, 0), strict=True))
    write_channels(
        folder / "xyz.exr", {name: np.float32(plane) for name, plane in (planes | {"A": alpha}).items()}
    )
    if rgb:
        write_rgb(folder / "rgb.exr", image)


@pytest.fixture
def render(tmp_path) -> Path:
    """A render of white on grey in Rec.709: radiance 1 and 0.5."""
    cover, light = scene()
    folder = tmp_path / "render"
    ground = (0.5 * light * (1 - cover))[..., None] * np.ones(3, np.float32)
    one = np.ones((SIZE, SIZE), np.float32)
    write_part(folder, ground + cover[..., None], one)
    write_part(folder / "without", np.full((SIZE, SIZE, 3), 0.5, np.float32), one)
    write_objects(folder / "objects.exr", ObjectCoverage({"square": cover}, cover, 1 - cover))
    return folder


def expected(plate, radiance=1.0):
    """What the composite must be, for a plate whose ground is 0.5 as rendered."""
    cover, light = scene()
    shaded = plate + np.float32(0.5 * radiance) * (light[..., None] - 1)
    return shaded * (1 - cover)[..., None] + cover[..., None] * np.float32(radiance)


def textured_plate(level=0.5):
    return (level * np.random.default_rng(4).uniform(0.95, 1.05, (SIZE, SIZE, 3))).astype(np.float32)


def composite(render, plate, *words):
    output = render.parent / "composite"
    assert main(["composite", str(render), "--plate", str(plate), "-o", str(output), *words]) == 0
    return output


def test_exr_plate_is_composed_and_left_alone_bit_for_bit(render, tmp_path):
    plate = textured_plate()
    write_rgb(tmp_path / "plate.exr", plate)
    output = composite(render, tmp_path / "plate.exr")
    found = read_rgb(output / "composite.exr")
    np.testing.assert_allclose(found, expected(plate), atol=0.04)
    far = np.ones((SIZE, SIZE), bool)
    far[5:24, 6:30] = False
    np.testing.assert_array_equal(found[far], plate[far])
    np.testing.assert_array_equal(read_rgb(output / "plate.exr"), plate)
    np.testing.assert_allclose(xyz_to_rec709(read_rgb(output / "composite_xyz.exr", "XYZ")), found, atol=1e-5)
    np.testing.assert_allclose(read_rgb(output / "composite_rgb.exr"), found, atol=1e-5)
    assert "chromaticities" in read_channels(output / "composite.exr")[1]
    numbers = json.loads((output / "composite.json").read_text())
    assert numbers["objects"]["square"] == pytest.approx(105 / SIZE**2)
    assert {path.name for path in output.iterdir()} >= {
        "composite.png",
        "composite_rgb.png",
        "difference.png",
    }


def write_codes(path, codes):
    assert cv2.imwrite(str(path), codes[..., ::-1])


def test_untouched_pixels_of_a_converted_plate_keep_their_codes(render, tmp_path):
    codes = np.random.default_rng(0).integers(175, 200, (SIZE, SIZE, 3)).astype(np.uint8)
    write_codes(tmp_path / "plate.png", codes)
    output = composite(render, tmp_path / "plate.png", "--response", "srgb")
    found = cv2.imread(str(output / "composite.png"))[..., ::-1]
    far = np.ones((SIZE, SIZE), bool)
    far[5:24, 6:30] = False
    np.testing.assert_array_equal(found[far], codes[far])
    assert (found[11:19, 11:19] == 255).all()
    shaded = srgb_to_linear(found[12:18, 22:24] / 255.0) - srgb_to_linear(codes[12:18, 22:24] / 255.0)
    assert abs(shaded.mean() + 0.3) < 0.03


def test_a_measured_response_is_applied_both_ways(render, tmp_path):
    """A camera that shows light brighter than sRGB does: the composite's light goes through the inverse."""
    log_gain = np.repeat(np.linspace(-0.4, 0.4, len(KNOTS))[None], 3, 0)
    codes = np.full((SIZE, SIZE, 3), 150, np.uint8)
    write_codes(tmp_path / "plate.png", codes)
    (tmp_path / "report.json").write_text(
        json.dumps({"views": [{"matching": {"response_log_gain": log_gain.tolist()}}]})
    )
    output = composite(render, tmp_path / "plate.png", "--response", str(tmp_path / "report.json"))
    light = srgb_to_linear(150 / 255) * np.exp(np.interp(150 / 255, KNOTS, log_gain[0]))
    np.testing.assert_allclose(read_rgb(output / "plate.exr"), light, rtol=1e-3)
    found = cv2.imread(str(output / "composite.png"))
    assert (found[0, 0] == 150).all()


def test_exposure_scales_the_render_and_not_the_plate(render, tmp_path):
    write_codes(tmp_path / "plate.png", np.full((SIZE, SIZE, 3), 99, np.uint8))
    output = composite(
        render, tmp_path / "plate.png", "--response", "srgb", "--exposure-s", "0.02", "--iso", "1000"
    )
    found = read_rgb(output / "composite.exr")
    np.testing.assert_allclose(found[15, 15], 0.2, rtol=1e-5)
    np.testing.assert_allclose(found[0, 0], srgb_to_linear(99 / 255), rtol=1e-5)
    xyz = read_rgb(output / "composite_xyz.exr", "XYZ")  # in the unit of the render
    np.testing.assert_allclose(xyz_to_rec709(xyz[15, 15]), 1.0, rtol=1e-4)


@pytest.fixture
def nikon_render(render, frame_record) -> tuple[Path, np.ndarray]:
    """The same render with its passes, of spectra of a reddish light; and the camera's response to radiance 1."""
    cover, light = scene()
    spectrum = np.linspace(0.004, 0.012, 61)
    plan = reference_plan()
    images = {"": (0.5 * light * (1 - cover) + cover), "without": np.full((SIZE, SIZE), 0.5)}
    for name, image in images.items():
        folder = render / name
        save_plan(plan, folder / "plan.json")
        digest = digest_of(folder / "plan.json")
        passes = PassFolder(folder / "passes", {}, ("ViewLayer",), digest, frame_record())
        passes.write_index()
        for step in render_steps(plan, 8):
            at = np.interp(plan.wavelengths_nm[step.pass_number], plan.grid_nm, spectrum)
            planes = {f"0.world.{c}": np.float32(image * at[i]) for i, c in enumerate("RGB")}
            write_channels(passes.path(step.name), planes | {"0.alpha.V": np.ones((SIZE, SIZE), np.float32)})
            passes.note(step.name, 1.0, step.samples)
        write_part(folder, image[..., None] * xyz_to_rec709(spectra_to_xyz(spectrum)), np.ones((SIZE, SIZE)))
    return render, spectrum @ camera_sensitivities(NIKON) * STEP_NM


def test_a_raw_plate_is_composed_in_the_colours_of_its_camera(nikon_render, tmp_path):
    render, response = nikon_render
    plate = (textured_plate() * response).astype(np.float32)
    write_rgb(tmp_path / "plate.exr", plate)
    output = composite(render, tmp_path / "plate.exr", "--camera", NIKON)
    found = read_rgb(output / "composite.exr")
    np.testing.assert_allclose(found / response, expected(plate / response), atol=0.04)
    np.testing.assert_array_equal(found[0], plate[0])
    assert "chromaticities" not in read_channels(output / "composite.exr")[1]
    rgb = xyz_to_rec709(read_rgb(output / "composite_xyz.exr", "XYZ"))
    white = rgb[15, 15]
    np.testing.assert_allclose(rgb[0].mean(0) / white, 0.5, atol=0.02)  # plate and object agree in both eyes


def test_lens_distortion_is_put_on_the_render():
    """A render wider than the plate, bent: a point lands where the lens shows it."""
    camera = Camera((60.0, 60.0), (31.0, 19.0), (64, 40), (-0.2, 0.05, 0.001, 0.0, 0.0))
    backplate = Backplate(
        camera, np.eye(3), np.zeros(3), Path("p.jpg"), (64, 40), frame_px=(-6.0, -5.0, 78, 52)
    )
    columns, rows = np.meshgrid(np.arange(78) - 6 + 0.5, np.arange(52) - 5 + 0.5)
    rays = np.stack([(columns - 31) / 60, (rows - 19) / 60], -1).astype(np.float32)
    bent = Lens(backplate).picture(rays)
    assert bent.shape == (40, 64, 2)
    points = np.stack(np.meshgrid(np.arange(64) + 0.5, np.arange(40) + 0.5), -1)
    seen = pixel_rays(camera, points)
    np.testing.assert_allclose(bent, seen[..., :2] / seen[..., 2:], atol=3e-4)


def test_the_backplate_says_exposure_gain_and_response(render, tmp_path):
    write_codes(tmp_path / "plate.png", np.full((2 * SIZE, 2 * SIZE, 3), 120, np.uint8))
    log_gain = np.zeros((3, len(KNOTS))) + 0.1
    camera = Camera((50.0, 50.0), (20.0, 20.0), (SIZE, SIZE))
    plate = Backplate(
        camera,
        np.eye(3),
        np.zeros(3),
        tmp_path / "plate.png",
        (2 * SIZE, 2 * SIZE),
        (0.0, 0.0, SIZE, SIZE),
        response_log_gain=log_gain,
        exposure=0.5,
        gain=np.array([1.0, 1.2, 0.8]),
    )
    save_backplate(render / "backplate.json", plate)
    output = composite(render, tmp_path / "plate.png")
    found = read_rgb(output / "composite.exr")
    np.testing.assert_allclose(found[15, 15], [0.5, 0.6, 0.4], rtol=1e-5)
    np.testing.assert_allclose(found[0, 0], srgb_to_linear(120 / 255) * np.exp(0.1), rtol=1e-3)


# ---------------------------------------------------------------- bad input


def refused(capsys, *words):
    assert main(["composite", *map(str, words)]) == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    return told


def test_bad_plates_are_refused_in_one_line(render, tmp_path, capsys):
    output = ("-o", tmp_path / "out")
    write_codes(tmp_path / "plate.png", np.full((SIZE, SIZE, 3), 120, np.uint8))
    assert "--response srgb" in refused(capsys, render, "--plate", tmp_path / "plate.png", *output)
    write_codes(tmp_path / "small.png", np.full((8, 8, 3), 120, np.uint8))
    assert "8 x 8 pixels, the render 40 x 40" in refused(
        capsys, render, "--plate", tmp_path / "small.png", "--response", "srgb", *output
    )
    broken = textured_plate()
    broken[3, 3] = np.nan
    write_rgb(tmp_path / "broken.exr", broken)
    assert "1 pixels that are not finite" in refused(
        capsys, render, "--plate", tmp_path / "broken.exr", *output
    )
    assert "no response curve" in refused(
        capsys, render, "--plate", tmp_path / "plate.png", "--response", tmp_path / "broken.exr", *output
    )
    assert "no camera called" in refused(
        capsys, render, "--plate", tmp_path / "plate.png", "--response", "srgb", "--camera", "Nikon", *output
    )
    assert not (tmp_path / "out").exists()


def test_bad_renders_are_refused_in_one_line(render, tmp_path, capsys):
    write_rgb(tmp_path / "plate.exr", textured_plate())
    words = ("--plate", tmp_path / "plate.exr", "-o", tmp_path / "out")
    (render / "without" / "xyz.exr").rename(tmp_path / "kept.exr")
    assert "without the objects" in refused(capsys, render, *words)
    (tmp_path / "kept.exr").rename(render / "without" / "xyz.exr")
    cover, _ = scene()
    write_objects(render / "objects.exr", ObjectCoverage({}, 0 * cover, 1 + 0 * cover))
    assert "No virtual object" in refused(capsys, render, *words)
    write_objects(render / "objects.exr", ObjectCoverage({"square": cover}, cover, 1 - cover))
    write_part(render, np.zeros((SIZE, SIZE, 3), np.float32), np.ones((SIZE, SIZE)))
    assert "black" in refused(capsys, render, *words)
    (render / "objects.exr").unlink()
    assert "objects.exr" in refused(capsys, render, *words)
    (render / "xyz.exr").unlink()
    assert "no finished spectral render" in refused(capsys, render, *words)
    assert "no folder" in refused(capsys, tmp_path / "nowhere", *words)


def test_a_world_behind_the_objects_is_refused(render, tmp_path, capsys):
    cover, _ = scene()
    write_objects(render / "objects.exr", ObjectCoverage({"square": cover}, cover, 0 * cover))
    xyz, _ = read_channels(render / "xyz.exr")
    write_channels(render / "xyz.exr", {name: xyz[name] for name in "XYZ"})
    write_rgb(tmp_path / "plate.exr", textured_plate())
    assert "Transparent" in refused(capsys, render, "--plate", tmp_path / "plate.exr", "-o", tmp_path / "out")


def test_objects_alone_hide_the_plate_and_say_that_they_cast_no_shadow(render, tmp_path):
    cover, _ = scene()
    write_objects(render / "objects.exr", ObjectCoverage({"square": cover}, cover, 0 * cover))
    write_part(render, cover[..., None] * np.ones(3, np.float32), cover)
    plate = textured_plate()
    write_rgb(tmp_path / "plate.exr", plate)
    output = composite(render, tmp_path / "plate.exr")
    found = read_rgb(output / "composite.exr")
    np.testing.assert_array_equal(found[cover == 0], plate[cover == 0])
    np.testing.assert_allclose(found, plate * (1 - cover)[..., None] + cover[..., None], atol=1e-6)
    assert "no shadow catcher" in " ".join(json.loads((output / "composite.json").read_text())["remarks"])


def denoise(folder, xyz):
    """image.exr of a denoised render."""
    header = picture_header(working_space(), None, "of a test")
    header["comments"] += f"; {DENOISED_NOTE}"
    write_rgb(folder / "image.exr", picture_rgb(xyz, working_space(), None), header=header)


def test_objects_and_nothing_else_are_taken_from_a_denoised_render(render, tmp_path):
    cover, _ = scene()
    write_rgb(tmp_path / "plate.exr", textured_plate())
    plain = composite(render, tmp_path / "plate.exr")
    noisy = read_rgb(plain / "composite.exr")
    assert json.loads((plain / "composite.json").read_text())["denoised_objects"] is False
    # A darker square, and nonsense where no object is.
    darker = 0.5 * scene()[1] * (1 - cover) + np.where(cover > 0, 0.8 * cover, 7.0)
    denoise(render, darker[..., None] * rec709_to_xyz(np.ones(3)))
    output = composite(render, tmp_path / "plate.exr")
    found, numbers = read_rgb(output / "composite.exr"), json.loads((output / "composite.json").read_text())
    np.testing.assert_array_equal(found[cover == 0], noisy[cover == 0])
    np.testing.assert_allclose(found[cover == 1], 0.8, atol=1e-5)
    np.testing.assert_allclose(
        found[cover == 0.5], noisy[cover == 0.5] - 0.1, atol=0.01
    )  # edges keep their share
    assert numbers["denoised_objects"] is True
    assert any("composite_rgb" in remark for remark in numbers["remarks"])
    refused = composite(render, tmp_path / "plate.exr", "--as-rendered")
    np.testing.assert_array_equal(read_rgb(refused / "composite.exr"), noisy)


def test_denoised_objects_keep_the_colours_of_the_camera(nikon_render, tmp_path):
    render, response = nikon_render
    cover, _ = scene()
    write_rgb(tmp_path / "plate.exr", (textured_plate() * response).astype(np.float32))
    raw = read_rgb(composite(render, tmp_path / "plate.exr", "--camera", NIKON) / "composite.exr")
    denoise(render, read_rgb(render / "xyz.exr", "XYZ"))
    found = read_rgb(composite(render, tmp_path / "plate.exr", "--camera", NIKON) / "composite.exr")
    np.testing.assert_allclose(found[cover > 0], raw[cover > 0], rtol=5e-3)
