"""Write a small .blend with the settings of an earlier version, as that version's users would have.

The files beside this script were made from the commits in their names, with the `bpy` wheel of Blender 5.2:

    git archive COMMIT | tar -x -C FOLDER
    .venv/bin/python tests/addon/old_files/make.py FOLDER tests/addon/old_files/COMMIT.blend
"""

import gzip
import os
import sys
import tempfile
import tomllib
from pathlib import Path

_VALUES = tomllib.loads(Path(__file__).with_name("values.toml").read_text("utf-8"))


def _put(owner, values):
    """Set what the version has; tables are groups."""
    for name, value in values.items():
        known = owner.bl_rna.properties.get(name)
        if known is None:
            continue
        if isinstance(value, dict):
            _put(getattr(owner, name), value)
        else:
            setattr(owner, name, set(value) if known.type == "ENUM" and known.is_enum_flag else value)


def _world(bpy, module, scene, folder):
    """The world that the version's Light World made, where it stood turned and dimmed."""
    import importlib

    folder.mkdir()
    image = bpy.data.images.new("world", 8, 4, float_buffer=True)
    image.file_format, image.filepath_raw = "OPEN_EXR", str(folder / "world.exr")
    image.save()
    bpy.data.images.remove(image)
    try:
        light_world = importlib.import_module(f"{module}.operators.bridge.world").light_world
    except ModuleNotFoundError:  # before there was one
        return
    light_world(scene, folder / "world.exr", rotation_rad=0.75, strength=2.5)


def main(checkout, target):
    """Enable the extension of a checkout, fill a new file, save it compressed."""
    module = "bl_ext.user_default.spectral_probe"
    with tempfile.TemporaryDirectory() as resources:
        os.environ["BLENDER_USER_RESOURCES"] = resources
        repository = Path(resources) / "extensions" / "user_default"
        repository.mkdir(parents=True)
        (repository / "spectral_probe").symlink_to(checkout.resolve(), target_is_directory=True)
        import bpy  # noqa: I001  (not before its folders are set; it brings addon_utils)

        import addon_utils

        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        addon_utils.enable(module)
        scene = bpy.context.scene
        settings = scene.spectral_probe
        _put(settings, _VALUES["scene"])
        view = settings.views.add()
        _put(view, {name: value for name, value in _VALUES["view"].items() if name != "photos"})
        for path, exposure_s in zip(_VALUES["view"]["photos"], _VALUES["view"]["exposures_s"], strict=True):
            photo = view.photos.add()
            photo.path, photo.exposure_s = path, exposure_s
        for name in ("metal", "surface"):
            material = bpy.data.materials.new(name)
            material.use_fake_user = True
            _put(material.spectral_probe, _VALUES[name])
        _world(bpy, module, scene, Path(resources) / "room probe")
        for image in bpy.data.images:
            image.filepath = f"//room probe/{Path(image.filepath).name}"
        blocks = {
            scene,
            *bpy.data.materials,
        }  # without the window's screens and brushes, which are most of a file
        bpy.data.libraries.write(str(target.resolve()), blocks, path_remap="NONE")
        target.write_bytes(
            gzip.compress(target.read_bytes(), mtime=0)
        )  # smaller than Blender's own, which it also reads


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
