"""A digest of everything that shapes a scene's picture: the same after saving and reopening, another after a visible change.

Nothing of the session enters (addresses, selection, what editors show), nothing of where files lie (they enter by their
content), and nothing of the settings that a spectral render sets itself. Datablocks are walked from the scene, through every
pointer; geometry is read whole. What modifiers, drivers, constraints, physics and instancing make of it is taken from the
evaluated scene.
"""

import hashlib
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ...spectral_probe.model import SpectralPanorama
from .file_digest import file_digest

_DIGEST_BYTES = 16

_RENDER_SETTINGS = (
    "engine", "resolution_x", "resolution_y", "resolution_percentage", "pixel_aspect_x", "pixel_aspect_y", "filter_size",
    "film_transparent", "use_motion_blur", "motion_blur_shutter", "motion_blur_position", "motion_blur_shutter_curve",
    "use_border", "border_min_x", "border_min_y", "border_max_x", "border_max_y", "use_crop_to_border", "hair_type",
    "hair_subdiv", "use_high_quality_normals", "use_simplify", "simplify_subdivision_render",
    "simplify_child_particles_render", "simplify_volumes", "use_simplify_normals", "use_single_layer",
)  # fmt: skip

_CYCLES_OWN_STARTS = ("preview_", "use_preview", "debug_", "denois", "sample", "bake", "texture_cache")
"""Beginnings of Cycles settings that shape no picture here, or that a spectral render sets itself."""

_CYCLES_OWN = {
    "device", "samples", "use_sample_subset", "time_limit", "use_denoising", "use_adaptive_sampling", "adaptive_threshold",
    "adaptive_min_samples", "blur_glossy", "use_fast_gi", "film_exposure", "tile_size", "use_auto_tile", "shading_system",
    "use_layer_samples", "ao_bounces", "ao_bounces_render", "fast_gi_method", "dicing_camera",
}  # fmt: skip

_LAYER_SETTINGS = ("name", "use", "material_override", "use_solid", "use_sky", "use_ao", "use_strand", "use_volumes",
                   "use_motion_blur", "pass_alpha_threshold")  # fmt: skip

_OBJECT_SETTINGS = (
    "type", "hide_render", "is_holdout", "is_shadow_catcher", "visible_camera", "visible_diffuse", "visible_glossy",
    "visible_transmission", "visible_volume_scatter", "visible_shadow", "pass_index", "color", "lightgroup",
    "light_linking", "shadow_terminator_normal_offset", "shadow_terminator_geometry_offset",
    "shadow_terminator_shading_offset", "instance_type", "use_instance_vertices_rotation", "use_instance_faces_scale",
    "instance_faces_scale", "instance_collection", "show_instancer_for_render", "modifiers", "particle_systems", "cycles",
    "spectral_probe",
)  # fmt: skip

_SESSION = {
    "rna_type", "bl_rna", "name_full", "id_type", "session_uid", "original", "users", "use_fake_user", "use_extra_user",
    "tag", "library", "library_weak_reference", "asset_data", "override_library", "preview", "animation_data",
    "animation_visualization", "motion_path", "annotation", "grease_pencil", "parent", "location_absolute", "dimensions",
    "width", "height", "width_hidden", "label", "select", "hide", "use_custom_color", "color_tag", "panel_states",
    "internal_links", "warning_propagation", "use_nodes", "interface", "default_group_node_width", "view_center",
    "description", "texture_mesh", "is_linked", "is_unavailable", "is_inactive", "is_icon_visible", "pin_gizmo", "node",
    "display_shape", "inferred_structure_type", "hide_value", "enabled", "has_data", "pixels", "render_slots", "bindcode",
    "depsgraph", "hide_viewport", "hide_select", "users_dupli_set", "cache", "execution_time", "persistent_uid",
    "active_material", "texture_slots", "shape_keys", "debug_options", "dna_type",
}  # fmt: skip
"""Properties of any structure that belong to the session, to editors, or are said elsewhere."""

_SESSION_STARTS = ("bl_", "show_", "active_", "is_evaluated", "is_editable", "is_library", "is_missing", "is_runtime",
                   "is_embedded", "is_linked", "is_editmode", "total_", "use_pin", "use_apply_on")  # fmt: skip

_RENDERED = ("show_render",)
"""Exceptions: whether a modifier takes part in renders."""

_PATHS = ("FILE_PATH", "DIR_PATH")

_TABLES = (".csv", ".txt")
"""How files with spectra end, where a field takes names as well."""

_NODE_PLACE = "location"
"""Nodes' place in the editor: a property of nodes that other structures have, too, where it counts."""

_GEOMETRY = ("MESH", "CURVES", "POINTCLOUD")
_ELEMENT = {
    "FLOAT": ("value", np.float32, 1), "INT": ("value", np.int32, 1), "BOOLEAN": ("value", np.bool_, 1),
    "FLOAT_VECTOR": ("vector", np.float32, 3), "FLOAT2": ("vector", np.float32, 2),
    "FLOAT_COLOR": ("color", np.float32, 4), "BYTE_COLOR": ("color", np.float32, 4),
    "QUATERNION": ("value", np.float32, 4), "FLOAT4X4": ("value", np.float32, 16), "INT8": ("value", np.int32, 1),
    "INT32_2D": ("value", np.int32, 2), "INT16_2D": ("value", np.int32, 2),
}  # fmt: skip
"""Kinds of geometry attributes: name of the value, its type, and how many numbers it has."""


def scene_fingerprint(scene: bpy.types.Scene) -> str:
    """Digest of everything that shapes the scene's picture at its frame, but the light that a probe gives it."""
    walk = _Walk()
    for layer in scene.view_layers:
        layer.update()
    walk.add("frame", scene.frame_current, scene.frame_subframe)
    walk.named(scene.render, _RENDER_SETTINGS)
    walk.structure(scene.cycles, lambda name: name in _CYCLES_OWN or name.startswith(_CYCLES_OWN_STARTS))
    walk.structure(scene.cycles_curves)
    walk.datablock(scene.camera)
    walk.datablock(scene.world)
    for member in sorted(scene.objects, key=lambda thing: thing.name_full):
        walk.datablock(member)
    for layer in scene.view_layers:
        walk.named(layer, _LAYER_SETTINGS)
        walk.collections(layer.layer_collection)
        walk.evaluated(layer.depsgraph)
    walk.add(bpy.data.colorspace.working_space)
    return walk.digest()


def light_fingerprint(probe: SpectralPanorama | None) -> str:
    """Digest of a panorama's light; the scene's own world is part of the scene."""
    if probe is None:
        return "the scene's own world"
    digest = hashlib.blake2b(digest_size=_DIGEST_BYTES)
    for array in (probe.weights, probe.bases, probe.basis_index, probe.wavelengths_nm):
        digest.update(repr((array.shape, str(array.dtype))).encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


class _Walk:
    """Feeds one digest with what is reached; a datablock's content is told once, then its name."""

    def __init__(self, seen: set[int] | None = None) -> None:
        self._hash = hashlib.blake2b(digest_size=_DIGEST_BYTES)
        self._seen = set() if seen is None else seen
        self._within: set[tuple[str, int]] = set()

    def digest(self) -> str:
        """Digest of all that was added."""
        return self._hash.hexdigest()

    def add(self, *values: object) -> None:
        """Add plain values."""
        self._hash.update(repr(values).encode("utf-8", "surrogateescape"))

    def array(self, values: np.ndarray[Any, Any]) -> None:
        """Add an array."""
        self.add(values.shape)
        self._hash.update(values.tobytes())

    # ------------------------------------------------------------ datablocks

    def datablock(self, block: bpy.types.ID | None) -> None:
        """Add a datablock: its content where it is met first."""
        if block is None:
            self.add(None)
            return
        self.add(type(block).__name__, block.name_full)
        if block.as_pointer() in self._seen:
            return
        self._seen.add(block.as_pointer())
        if isinstance(block, bpy.types.Object):
            self._object(block)
        elif isinstance(block, bpy.types.Collection):
            for member in sorted(block.all_objects, key=lambda thing: thing.name_full):
                self.datablock(member)
        elif isinstance(block, bpy.types.Scene):
            self.add(block.name)  # a background set, or one that a driver looks at
        elif isinstance(block, bpy.types.Image):
            self._image(block)
        elif isinstance(block, bpy.types.NodeTree):
            self._tree(block)
        elif type(block).__name__.upper() in _GEOMETRY:
            self.geometry(block)
        else:
            self.structure(block)
            self._file(getattr(block, "filepath", ""), block.library)

    def _object(self, thing: bpy.types.Object) -> None:
        self.named(thing, _OBJECT_SETTINGS)
        self.array(np.array(thing.matrix_world, np.float32))
        self.custom(thing)
        for slot in thing.material_slots:
            self.add(slot.link)
            self.datablock(slot.material)
        if thing.type != "GREASEPENCIL":  # left out of spectral renders
            self.datablock(thing.data)

    def _image(self, image: bpy.types.Image) -> None:
        if image.type in {"RENDER_RESULT", "COMPOSITING"}:
            return
        names = (
            "source",
            "generated_type",
            "generated_width",
            "generated_height",
            "generated_color",
            "alpha_mode",
        )
        self.named(image, names)
        self.add(image.colorspace_settings.name)
        for packed in image.packed_files:
            if packed.packed_file is not None:
                self._hash.update(packed.packed_file.data)
        if image.source != "GENERATED" and not image.packed_files:
            for path in image_files(image):
                self._file(str(path))
        if image.is_dirty and image.size[0]:
            pixels = np.empty(len(image.pixels), np.float32)
            image.pixels.foreach_get(pixels)
            self.array(pixels)

    def _tree(self, tree: bpy.types.NodeTree) -> None:
        for node in tree.nodes:
            self.add(node.bl_idname)
            self.structure(node, lambda name: name == _NODE_PLACE)
        links = [
            (link.from_node.name, link.from_socket.identifier, link.to_node.name, link.to_socket.identifier, link.is_muted)
            for link in tree.links
        ]  # fmt: skip
        self.add(sorted(links))

    def geometry(self, data: bpy.types.ID) -> None:
        """Add a mesh, hair curves or a point cloud: topology, every attribute, materials."""
        if isinstance(data, bpy.types.Mesh):
            for elements, name in (
                (data.polygons, "loop_start"),
                (data.loops, "vertex_index"),
                (data.edges, "vertices"),
            ):
                width = 2 if name == "vertices" else 1
                values = np.empty(len(elements) * width, np.int32)
                elements.foreach_get(name, values)
                self.array(values)
        elif isinstance(data, bpy.types.Curves):
            self.array(np.array([offset.value for offset in data.curve_offset_data], np.int32))
        for attribute in data.attributes:
            if attribute.name.startswith(".") and attribute.name not in {".corner_vert", ".edge_verts"}:
                continue  # selections and the like
            self.add(attribute.name, attribute.domain, attribute.data_type)
            kind = _ELEMENT.get(attribute.data_type)
            if kind is None or not len(attribute.data):
                continue
            name, dtype, width = kind
            values = np.empty(len(attribute.data) * width, dtype)
            attribute.data.foreach_get(name, values)
            self.array(values)
        for material in data.materials:
            self.datablock(material)
        self.custom(data)

    def _file(self, path: str, library: bpy.types.Library | None = None) -> None:
        """Add a file by its content, wherever it lies; one that is not there by its name."""
        if path:
            file = Path(bpy.path.abspath(path, library=library))
            own_name = file.name if path.startswith("//") or Path(path).is_absolute() else path
            self.add(file_digest(file) or own_name)

    # ------------------------------------------------------------ structures

    def named(self, owner: Any, names: Iterable[str]) -> None:
        """Add the properties of these names that a structure has."""
        for name in names:
            if name in owner.bl_rna.properties:
                self._property(owner, owner.bl_rna.properties[name])

    def structure(self, owner: Any, left_out: Callable[[str], bool] = lambda _: False) -> None:
        """Add all properties of a structure but those that are left out."""
        for prop in owner.bl_rna.properties:
            name = prop.identifier
            session = name in _SESSION or (name.startswith(_SESSION_STARTS) and name not in _RENDERED)
            if session or left_out(name):
                continue
            self._property(owner, prop)
        self.custom(owner)

    def _property(self, owner: Any, prop: bpy.types.Property) -> None:
        name = prop.identifier
        if prop.type == "POINTER":
            value = getattr(owner, name)
            self.add(name)
            self._value(value)
        elif prop.type == "COLLECTION":
            self.add(name)
            for value in getattr(owner, name):
                self._value(value)
        elif isinstance(value := getattr(owner, name), set):
            self.add(name, sorted(value))
        elif getattr(prop, "is_array", False):
            self.add(name, np.array(value).tolist())
        elif prop.type == "STRING" and (prop.subtype in _PATHS or value.endswith(_TABLES)):
            self.add(name)
            self._file(value)
        else:
            self.add(name, value)

    def _value(self, value: Any) -> None:
        if isinstance(value, bpy.types.ID):
            self.datablock(value)
        elif value is None:
            self.add(None)
        elif hasattr(value, "bl_rna"):
            key = (type(value).__name__, value.as_pointer())
            self.add(key[0])
            if isinstance(value, bpy.types.NodeLink) or key in self._within:
                return  # links are told by the tree; parts may point back to what they are part of
            self._within.add(key)
            self.structure(value)
            self._within.remove(key)

    def custom(self, owner: Any) -> None:
        """Add custom properties: inputs of geometry nodes, and what shaders read as attributes."""
        if isinstance(owner, bpy.types.PropertyGroup):
            return  # its items are its properties, as far as they were ever set
        try:
            items = sorted(owner.items(), key=lambda item: item[0])
        except (AttributeError, TypeError):
            return  # a structure that can have none
        for name, value in items:
            if isinstance(value, bpy.types.ID):
                self.add(name)
                self.datablock(value)
            elif hasattr(value, "to_dict"):
                self.add(name, sorted(map(repr, value.to_dict().items())))
            elif hasattr(value, "to_list"):
                self.add(name, value.to_list())
            else:
                self.add(name, value)

    # ------------------------------------------------------------ what is made of it

    def collections(self, layer: bpy.types.LayerCollection) -> None:
        """Add which collections a view layer shows, and how."""
        self.add(layer.name, layer.exclude, layer.holdout, layer.indirect_only, layer.collection.hide_render)
        for child in layer.children:
            self.collections(child)

    def evaluated(self, depsgraph: bpy.types.Depsgraph) -> None:
        """Add what is drawn in the end: places of all instances, and the geometry that modifiers made."""
        shapes: dict[int, str] = {}
        found = []
        for instance in depsgraph.object_instances:
            thing = instance.object
            place = np.array(instance.matrix_world, np.float32).tobytes()
            found.append((thing.name_full, place, self._shape(thing, instance.is_instance, shapes)))
        for entry in sorted(found):
            self.add(*entry)

    def _shape(self, thing: bpy.types.Object, made: bool, shapes: dict[int, str]) -> str:
        """Digest of an evaluated object's geometry, where it may differ from the original's."""
        data = thing.data
        if data is None or thing.type not in _GEOMETRY or not (made or thing.modifiers or _has_keys(data)):
            return ""
        key = data.as_pointer()
        if key not in shapes:
            walk = _Walk(self._seen)  # materials are told once
            walk.geometry(data)
            shapes[key] = walk.digest()
        return shapes[key]


def _has_keys(data: bpy.types.ID) -> bool:
    return getattr(data, "shape_keys", None) is not None


def image_files(image: bpy.types.Image) -> list[Path]:
    """The files of an image, one for each tile of a UDIM; none where it has no path."""
    if not image.filepath:
        return []
    path = bpy.path.abspath(image.filepath, library=image.library)
    if image.source != "TILED":
        return [Path(path)]
    return [
        Path(path.replace("<UDIM>", str(tile.number)).replace("<UVTILE>", _uv_tile(tile.number)))
        for tile in image.tiles
    ]


def _uv_tile(number: int) -> str:
    """A UDIM's number as u1_v1 counts it."""
    return f"u{(number - 1001) % 10 + 1}_v{(number - 1001) // 10 + 1}"
