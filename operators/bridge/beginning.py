"""A frame begun: its plan made and written, and what putting it together needs of the scene kept beside it.

What is there of an interrupted render of the same is gone on with. The index of the passes comes last: where it is, the frame was
begun, and other processes may render any of its steps.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import bpy

from ...spectral_probe.composite.backplate_file import backplate_table
from ...spectral_probe.composite_model import WITHOUT_NAME
from ...spectral_probe.files.atomic import remove_leftovers, written_whole
from ...spectral_probe.light_choice import mean_light
from ...spectral_probe.model import Job, Progress, SpectralPanorama
from ...spectral_probe.render.frame_record import FrameRecord
from ...spectral_probe.render.light_file import save_light_sets
from ...spectral_probe.render.outputs import OutputSettings
from ...spectral_probe.render.pass_folder import INDEX_NAME, PassFolder, digest_of, open_pass_folder
from ...spectral_probe.render.plan import load_plan, reference_plan, save_plan
from ...spectral_probe.render_model import LightSet, PassPlan
from ...spectral_probe.work import worked
from .assembling import PLAN_NAME, remove_pictures, told_where_not_written
from .backplate import backplates_of
from .camera_backplate import rendered_size
from .catchers import Surfaces, surfaces
from .light import LayerLight, WavelengthLight, light_level
from .materials import SpectralMaterials, spectral_materials, working_to_rec709
from .own_world import OwnWorld, own_world_light
from .parts import Frame, of_without, parts_of, remove_part
from .pass_settings import enabled_layers, left_out
from .planning import Planner
from .render_report import blend_from
from .resuming import OnChange, begun_folder, folder_to_go_on, refuse_probe_folder, render_fingerprint
from .same_scene import check_same, contents
from .world import volume_left_out

PLANNING = "Planning the passes"


@dataclass(frozen=True)
class FrameWords:
    """What a render is told besides its light and plan.

    `rgb_twin` asks for the scene in plain RGB, too; `outputs` say what is written; `on_change` what to do with passes of an
    unfinished render of something else; `words` are those of the command line, to be told again where steps are missing; `files`
    is `file_digest.opened_files_digest` where the scene was just opened.
    """

    rgb_twin: bool = True
    outputs: OutputSettings = field(default_factory=OutputSettings)
    on_change: OnChange = "refuse"
    words: tuple[str, ...] = ()
    files: str = ""


@dataclass(frozen=True)
class _Planned:
    """A plan, what its light layers lack, whether lamps or materials shine beside the world, and the layers."""

    plan: PassPlan
    residual: float
    emits: bool
    sets: tuple[LightSet, ...] = ()


def begin(
    scene: bpy.types.Scene,
    planner: Planner,
    directory: Path,
    words: FrameWords,
    light_folder: Path | None = None,
) -> Job[Frame]:
    """Begin a frame in its folder, or go on with it; the folder's lock is the caller's.

    Light layers are written into `light_folder`, where other tasks are to read them.

    Raises
    ------
    RenderError
        If it is the folder of a probe; a `resuming.SceneChangedError` if `words.on_change` has to be decided.
    """
    refuse_probe_folder(directory)
    found = surfaces(scene)
    fingerprint = render_fingerprint(scene, planner)
    earlier = folder_to_go_on(directory, fingerprint, words.on_change, words.files, scene.frame_current)
    yield Progress(0.0, PLANNING)
    plan = None if earlier is None else load_plan(directory / PLAN_NAME)
    made = yield from _plan(scene, planner, plan)
    record = yield from _record(scene, planner, found, made, words, directory)
    if light_folder is not None and made.sets and planner.probe is not None:
        save = partial(save_light_sets, made.sets, light_folder)
        record = replace(record, light=(yield from worked(Progress(0.0, PLANNING), save)))
    layers = tuple(layer.name for layer in enabled_layers(scene))
    with told_where_not_written(directory):
        if earlier is None:
            whole = _begin_anew(directory, fingerprint, layers, made.plan, record, words.on_change)
        else:
            level = earlier.record.twin_level or record.twin_level
            kept = earlier.record.samples
            record = replace(
                record, samples=kept, twin_level=level if words.rgb_twin else None, light=earlier.record.light
            )
            whole = replace(earlier, record=record)
            remove_pictures(directory, earlier.view_layers)
        folders = [whole]
        if record.without:
            folders.append(_without(whole, anew=earlier is None, keep=words.on_change != "restart"))
        else:
            remove_part(directory / WITHOUT_NAME)
        for folder in reversed(folders):
            remove_leftovers(folder.directory)
            folder.write_index()
    return Frame(scene, planner, made.plan, parts_of(folders, found), found)


def joined(scene: bpy.types.Scene, planner: Planner, whole: PassFolder) -> Frame:
    """A frame that another process has begun, as one of the same scene in the same light."""
    found = surfaces(scene)
    folders = [whole, of_without(whole)] if whole.record.without else [whole]
    plan = load_plan(whole.directory.parent / PLAN_NAME)
    return Frame(scene, planner, plan, parts_of(folders, found), found)


def making_plan(scene: bpy.types.Scene, planner: Planner) -> Job[PassPlan]:
    """Make the plan that a render makes with a planner for a scene, which comes back as it was."""
    if planner.given is not None:
        return planner.given
    if planner.request.passes == "all":
        return reference_plan()
    progress = Progress(0.3, PLANNING)
    level = yield from worked(progress, partial(light_level, planner.probe))
    with translated(scene, planner.probe, True, level) as (materials, world):
        return (yield from worked(progress, partial(planner.plan, materials, world)))


@contextmanager
def translated(
    scene: bpy.types.Scene, probe: SpectralPanorama | None, one_wavelength: bool, level: float
) -> Iterator[tuple[SpectralMaterials, OwnWorld | None]]:
    """Materials and lamps that can be set to wavelengths, and the scene's own world where no probe lights it."""
    with spectral_materials(scene, one_wavelength=one_wavelength, level=level) as materials:
        if probe is not None:
            yield materials, None
            return
        lamps = bool(materials.emitters)
        with own_world_light(scene, one_wavelength=one_wavelength, level=level, may_be_dark=lamps) as world:
            yield materials, world


def _plan(scene: bpy.types.Scene, planner: Planner, kept: PassPlan | None) -> Job[_Planned]:
    """The plan, as it is or made now, checked against the scene's light."""
    progress = Progress(0.0, PLANNING)
    level = yield from worked(progress, partial(light_level, planner.probe))
    plan, residual, sets = kept or planner.given, 0.0, tuple[LightSet, ...]()
    of_layers = plan.kind == "light-basis" if plan else planner.request.passes != "all"
    with translated(scene, planner.probe, of_layers, level) as (materials, world):
        seen = contents(scene)
        if plan is None:
            plan = reference_plan()
            if of_layers:
                plan = yield from worked(progress, partial(planner.plan, materials, world))
        if plan.kind == "light-basis":
            sets = yield from worked(progress, partial(planner.sets, materials, world))
            light = LayerLight(sets, materials.emission, world)
            plan, residual = light.checked(plan), light.residual
        check_same(scene, seen)
        emits = bool(materials.emitters)
    if plan.kind == "wavelength" and kept is None:  # the passes there are were divided by their own level
        plan = WavelengthLight(planner.probe, level, []).checked(plan)
    return _Planned(plan, residual, emits, sets)


def _record(
    scene: bpy.types.Scene,
    planner: Planner,
    found: Surfaces,
    made: _Planned,
    words: FrameWords,
    directory: Path,
) -> Job[FrameRecord]:
    """What putting the frame together needs of the scene and its light."""
    progress, probe = Progress(0.0, PLANNING), planner.probe
    mean = None if probe is None else (yield from worked(progress, partial(mean_light, probe)))
    level = 1.0 if words.rgb_twin else None
    if probe is not None and words.rgb_twin and not made.emits:  # lamps shine as the user set them
        level = yield from worked(progress, partial(planner.rec709_level, probe))
    whole, cropped = (
        None if one is None else backplate_table(one, directory) for one in backplates_of(scene)
    )
    catchers, virtual = found.names
    return FrameRecord(
        scene=scene.name,
        frame=scene.frame_current,
        blend=blend_from(directory),
        blender=bpy.app.version_string,
        samples=planner.samples,
        to_rec709=working_to_rec709(),
        denoise=bool(scene.cycles.use_denoising),
        catchers=catchers,
        virtual=virtual,
        without=bool(catchers and virtual),
        rgb_twin=words.rgb_twin,
        twin_level=level,
        light_residual=made.residual,
        mean_light=mean,
        backplates=(whole, cropped),
        frame_px=rendered_size(scene),
        outputs=words.outputs,
        warnings=(
            *left_out(scene),
            *(volume_left_out(scene.world) if probe is not None else ()),
            *found.warnings,
        ),
        words=words.words,
        files=words.files,
    )


# ---------------------------------------------------------------- the folders


def _begin_anew(
    directory: Path,
    fingerprint: dict[str, str],
    layers: tuple[str, ...],
    plan: PassPlan,
    record: FrameRecord,
    on_change: OnChange,
) -> PassFolder:
    """Remove what an earlier render left and does not belong here, and write the plan."""
    passes = directory / "passes"
    earlier = open_pass_folder(passes)
    (passes / INDEX_NAME).unlink(missing_ok=True)  # first: without it nothing counts
    for view_layers in (() if earlier is None else earlier.view_layers, layers):
        remove_pictures(directory, view_layers)
    save_plan(plan, directory / PLAN_NAME)
    folder = PassFolder(passes, fingerprint, layers, digest_of(directory / PLAN_NAME), record)
    folder.clear(keep=on_change != "restart")
    return folder


def _without(whole: PassFolder, *, anew: bool, keep: bool) -> PassFolder:
    """The folder of the part without virtual objects, begun anew where it is not that of the whole."""
    frame = whole.directory.parent
    alone = frame / WITHOUT_NAME
    folder = of_without(whole)
    before = begun_folder(alone)
    for view_layers in (() if before is None else before.view_layers, whole.view_layers):
        remove_pictures(alone, view_layers)
    if anew or before is None or (before.fingerprint, before.plan) != (folder.fingerprint, folder.plan):
        (folder.directory / INDEX_NAME).unlink(missing_ok=True)
        with written_whole(alone / PLAN_NAME) as temporary:
            temporary.write_bytes((frame / PLAN_NAME).read_bytes())
        folder.clear(keep=keep)
    return folder
