"""The copy of a probe's files that the .blend holds: `Scene.spectral_probe.packed`."""

import bpy
from bpy.props import BoolProperty, CollectionProperty, IntProperty, PointerProperty, StringProperty


class SPECTRAL_PROBE_PG_packed_file(bpy.types.PropertyGroup):
    """One file; its name is its place in the folder of the probe, with slashes."""

    image: PointerProperty(
        type=bpy.types.Image, name="Image", description="Datablock in which Blender keeps the file's content"
    )
    text: StringProperty(name="Text", description="Content of a text file")
    digest: StringProperty(name="Digest", description="Digest of the content, by which another file is told")
    size_bytes: IntProperty(name="Size", description="Size of the file in bytes", min=0)


class SPECTRAL_PROBE_PG_packed(bpy.types.PropertyGroup):
    """What is packed, and whether it is to be packed anew."""

    files: CollectionProperty(type=SPECTRAL_PROBE_PG_packed_file, name="Packed Files")
    outdated: BoolProperty(
        name="Outdated",
        description="The probe was built or edited since it was packed; it is packed anew when the .blend is saved",
    )


CLASSES = (SPECTRAL_PROBE_PG_packed_file, SPECTRAL_PROBE_PG_packed)
"""To be registered before the scene's settings."""
