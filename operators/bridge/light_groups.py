"""Cycles light groups of a render's lamps and emitting objects, put there for a while and taken away exactly."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager

import bpy

from ...spectral_probe.render_model import WORLD
from .restore import changed, in_scene, is_gone


@contextmanager
def light_groups(
    scene: bpy.types.Scene, groups: Sequence[str], members: Mapping[bpy.types.Object, str]
) -> Iterator[None]:
    """Put objects into light groups that all view layers have while the block runs; nothing is done without groups.

    Objects that emit nothing are in none of them. The user's own groups stay in the view layers, without members: taking them
    away would cut links in the compositor.
    """
    with ExitStack() as stack:
        if groups:
            for layer in scene.view_layers:
                stack.enter_context(_on_layer(layer, (WORLD, *groups)))
            for thing in shown_objects(scene):
                group = members.get(thing, "")
                if thing.lightgroup != group:
                    stack.enter_context(changed(thing, lightgroup=group))
        yield


@contextmanager
def _on_layer(layer: bpy.types.ViewLayer, names: Sequence[str]) -> Iterator[None]:
    """Light groups of a view layer besides those that it has."""
    scene, active = layer.id_data, layer.active_lightgroup_index
    missing = [name for name in names if name not in layer.lightgroups]
    try:
        for name in missing:
            layer.lightgroups.add(name=name)
        yield
    finally:
        if not is_gone(scene) and layer in scene.view_layers[:]:
            for name in missing:
                if name in layer.lightgroups:
                    layer.lightgroups.remove(layer.lightgroups[name])
            layer.active_lightgroup_index = active


def shown_objects(scene: bpy.types.Scene) -> list[bpy.types.Object]:
    """The objects of a scene, and those that it shows as instances of collections that are not in it."""
    return in_scene(scene, bpy.data.objects)


def shown_by(
    scene: bpy.types.Scene, owners: Sequence[bpy.types.ID]
) -> list[tuple[bpy.types.Object, set[bpy.types.ID]]]:
    """The objects of a scene that show any of some lamps and materials, with which.

    Followed from each lamp or material to the objects that use it, through meshes, geometry nodes and, where these make one
    object's geometry another's, through objects. A material that overrides a view layer's is on all objects.
    """
    users = bpy.data.user_map()
    shown: dict[bpy.types.Object, set[bpy.types.ID]] = {}
    for owner in owners:
        pending, seen = [owner], {owner}
        while pending:
            current = pending.pop()
            if isinstance(current, bpy.types.Object):
                shown.setdefault(current, set()).add(owner)
            for user in users.get(current, set()) - seen:
                if _passes_on(current, user):
                    seen.add(user)
                    pending.append(user)
        if any(layer.material_override == owner for layer in scene.view_layers):
            for thing in shown_objects(scene):
                if thing.type not in {"LIGHT", "CAMERA", "EMPTY"}:
                    shown.setdefault(thing, set()).add(owner)
    return [(thing, shown[thing]) for thing in shown_objects(scene) if thing in shown]


def _passes_on(used: bpy.types.ID, user: bpy.types.ID) -> bool:
    """Whether what is used shows in its user: a collection or an object only where geometry nodes may take it in."""
    if isinstance(user, bpy.types.Scene):
        return False
    if isinstance(used, bpy.types.Object | bpy.types.Collection):
        takes_in = isinstance(user, bpy.types.Object) and any(m.type == "NODES" for m in user.modifiers)
        return takes_in or isinstance(user, bpy.types.NodeTree | bpy.types.Collection)
    return True
