"""Render settings of the passes, and of their RGB twin: what is set while they render, and put back afterwards.

What Cycles would add to or take from the light is off: clamping, filtered glossy rays, adaptive sampling and denoising bias a
pass, each in its own way, and passes must add up. Film, camera, depth of field, motion blur, border and simplification stay
as they are.
"""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

import bpy

from .restore import changed

_FEATURES_KEPT = ("use_pass_combined",)


@dataclass(frozen=True)
class PassSettings:
    """The scene's settings while passes render.

    `layers` are the view layers rendered, in their order.
    """

    scene: bpy.types.Scene
    layers: tuple[bpy.types.ViewLayer, ...]

    def set_samples(self, sequence: int, first: int, count: int) -> None:
        """Let the next render take samples ``first`` to ``first + count`` of a sequence.

        The part of a sequence is exactly what a render of the whole sequence would take there.
        """
        cycles = self.scene.cycles
        cycles.samples, cycles.use_sample_subset = sequence, True
        cycles.sample_offset, cycles.sample_subset_length = first, count
        self.scene.update_tag()  # with persistent data Cycles does not look at changed sample settings otherwise


@contextmanager
def pass_settings(scene: bpy.types.Scene) -> Iterator[PassSettings]:
    """The settings of the passes while the block runs."""
    layers = enabled_layers(scene)
    with ExitStack() as stack:
        stack.enter_context(
            changed(
                scene.cycles,
                sample_clamp_direct=0.0,
                sample_clamp_indirect=0.0,
                blur_glossy=0.0,
                use_adaptive_sampling=False,
                use_denoising=False,
                use_fast_gi=False,
                time_limit=0.0,
                film_exposure=1.0,
                samples=scene.cycles.samples,
                use_sample_subset=scene.cycles.use_sample_subset,
                sample_offset=scene.cycles.sample_offset,
                sample_subset_length=scene.cycles.sample_subset_length,
            )
        )
        stack.enter_context(
            changed(
                scene.render,
                use_persistent_data=True,
                use_multiview=False,
                use_stamp=False,
                use_freestyle=False,
                use_single_layer=False,
            )
        )
        for layer in layers:
            stack.enter_context(
                changed(layer, layer, use=True, samples=0, world_override=None, use_grease_pencil=False)
            )
            stack.enter_context(changed(layer, layer, **dict.fromkeys(_features(layer), False)))
            stack.enter_context(changed(layer, layer, use_pass_combined=True))
            stack.enter_context(
                changed(layer.cycles, layer, use_denoising=False, denoising_store_passes=False)
            )
        yield PassSettings(scene, layers)


def enabled_layers(scene: bpy.types.Scene) -> tuple[bpy.types.ViewLayer, ...]:
    """View layers that a render of the scene renders; the first one where none is enabled."""
    if scene.render.use_single_layer and bpy.context.scene == scene:
        return (bpy.context.view_layer,)
    return tuple(layer for layer in scene.view_layers if layer.use) or (scene.view_layers[0],)


def _features(layer: bpy.types.ViewLayer) -> list[str]:
    """The feature passes of a view layer that are on: no one sees them here, and some cost time."""
    names = [p.identifier for p in layer.bl_rna.properties if p.identifier.startswith("use_pass_")]
    return [name for name in names if name not in _FEATURES_KEPT and getattr(layer, name)]


def left_out(scene: bpy.types.Scene) -> Iterator[str]:
    """Sentences on what the scene has and its passes leave out."""
    render, layers = scene.render, enabled_layers(scene)
    if render.use_multiview:
        yield "Stereoscopy is off in a spectral render: the scene's own camera was rendered once."
    if render.use_freestyle and any(layer.use_freestyle for layer in layers):
        yield "Freestyle lines are not spectral and were left out, of the RGB render too."
    if any(layer.world_override not in {None, scene.world} for layer in layers):
        yield "Worlds that view layers have of their own were left out: all layers were lit alike."
    if any(thing.type == "GREASEPENCIL" and not thing.hide_render for thing in scene.objects):
        yield "Grease Pencil strokes are not spectral and were left out, of the RGB render too."
