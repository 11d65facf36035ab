"""Which objects of a scene stand for real surfaces, and the scene with and without the others.

Real surfaces are those with Blender's own flag, Shadow Catcher. For differential rendering (Debevec 1998,
doi:10.1145/280814.280864) they are rendered as ordinary surfaces, once with the virtual objects and once alone. Holdouts are
real too: they hide what is behind them, in both renders. Lamps light both.
"""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass

import bpy

from .light_groups import shown_objects
from .pass_settings import enabled_layers
from .restore import changed

_NO_SURFACE = {"LIGHT", "LIGHT_PROBE", "CAMERA", "EMPTY", "SPEAKER", "ARMATURE", "LATTICE", "GREASEPENCIL"}
_RAYS = ("camera", "diffuse", "glossy", "transmission", "volume_scatter", "shadow")


@dataclass(frozen=True)
class Surfaces:
    """What a scene's renders show.

    `catchers` stand for real surfaces, `virtual` are the other bodies; objects that only instances show are among them.
    `warnings` name what will hardly be meant.
    """

    catchers: tuple[bpy.types.Object, ...]
    virtual: tuple[bpy.types.Object, ...]
    warnings: tuple[str, ...]

    @property
    def names(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Names of the catchers, and of the virtual objects."""
        return tuple(one.name for one in self.catchers), tuple(one.name for one in self.virtual)


def surfaces(scene: bpy.types.Scene) -> Surfaces:
    """Sort the objects that renders of a scene show at its frame.

    An instance is a catcher where its object is one, or what instances it, as in Cycles. An object that is shown as both counts
    as virtual.
    """
    real: dict[bpy.types.Object, bool] = {}
    held: set[bpy.types.Object] = set()
    for thing, maker in _shown(scene):
        if thing.type not in _NO_SURFACE:
            real[thing] = real.get(thing, True) and _is_catcher(thing, maker)
            if thing.is_holdout or any(
                thing.holdout_get(view_layer=layer)
                for layer in enabled_layers(scene)
                if thing.name in layer.objects
            ):
                held.add(thing)
    catchers = tuple(thing for thing, is_real in real.items() if is_real and thing not in held)
    virtual = tuple(thing for thing, is_real in real.items() if not is_real and thing not in held)
    return Surfaces(catchers, virtual, tuple(_doubts(scene, catchers, virtual)))


def _is_catcher(thing: bpy.types.Object, maker: bpy.types.Object | None) -> bool:
    return thing.is_shadow_catcher or (maker is not None and maker.is_shadow_catcher)


def _doubts(
    scene: bpy.types.Scene, catchers: tuple[bpy.types.Object, ...], virtual: tuple[bpy.types.Object, ...]
) -> Iterator[str]:
    for thing in scene.objects:
        if thing.is_shadow_catcher and thing.type not in _NO_SURFACE and thing not in catchers:
            yield (
                f'Shadow catcher "{thing.name}" is hidden in renders or a holdout, and was left out: no shadow falls on it.'
            )
    if catchers and not virtual:
        yield "All objects are shadow catchers: there is nothing virtual to put into a photograph."


def _shown(scene: bpy.types.Scene) -> Iterator[tuple[bpy.types.Object, bpy.types.Object | None]]:
    """Objects that a render shows, with what instances each; what only the viewport hides is shown, too."""
    for layer in enabled_layers(scene):
        for collection in _collections(layer.layer_collection):
            for thing in collection.objects:
                if thing.hide_render:
                    continue
                yield thing, None
                if thing.instance_type == "COLLECTION" and thing.instance_collection is not None:
                    for member in thing.instance_collection.all_objects:
                        if not member.hide_render:
                            yield member, thing
        layer.update()
        for instance in layer.depsgraph.object_instances:
            if instance.is_instance and instance.parent is not None:
                yield instance.object.original, instance.parent.original


def _collections(layer: bpy.types.LayerCollection) -> Iterator[bpy.types.Collection]:
    """The collections that a view layer renders."""
    if layer.exclude or layer.collection.hide_render:
        return
    yield layer.collection
    for child in layer.children:
        yield from _collections(child)


# ---------------------------------------------------------------- the scene, with and without


@contextmanager
def as_ordinary_surfaces(scene: bpy.types.Scene, found: Surfaces) -> Iterator[None]:
    """Let catchers be surfaces as any other while the block runs, and nothing be behind the scene; only where there are any."""
    with ExitStack() as stack:
        if found.catchers:
            stack.enter_context(changed(scene.render, film_transparent=True))
            stack.enter_context(changed(scene.cycles, film_transparent_glass=False))
            for thing in shown_objects(scene):
                if thing.is_shadow_catcher:
                    stack.enter_context(changed(thing, is_shadow_catcher=False))
        yield


def without_virtual(found: Surfaces) -> Callable[[], AbstractContextManager[None]]:
    """What hides the virtual objects while a block runs.

    Cycles leaves out what no kind of ray sees. Hiding them from renders could be undone by an animation of that, and would not
    reach instances made by geometry nodes.
    """

    @contextmanager
    def hidden() -> Iterator[None]:
        with ExitStack() as stack:
            for thing in found.virtual:
                stack.enter_context(changed(thing, **{f"visible_{ray}": False for ray in _RAYS}))
            yield

    return hidden
