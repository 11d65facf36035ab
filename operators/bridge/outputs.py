"""The files of a spectral render, in the working space of the .blend and denoised where that is wanted."""

from pathlib import Path

from ...spectral_probe.render.assemble import AssembledRender
from ...spectral_probe.render.outputs import OutputSettings, write_outputs
from ...spectral_probe.render_model import PassPlan
from ...spectral_probe.spectra.working_space import WorkingSpace, working_space
from .denoise import denoised
from .materials import working_to_rec709


def blend_space() -> WorkingSpace:
    """The working space of the open .blend."""
    return working_space(working_to_rec709())


def write_render(
    directory: Path,
    plan: PassPlan,
    render: AssembledRender,
    settings: OutputSettings,
    *,
    denoise: bool = False,
    suffix: str = "",
) -> dict[str, Path]:
    """Write xyz.exr, image.exr, render.exr and what else was asked for; returns the files by name.

    Parameters
    ----------
    directory
        Where to write.
    plan, render
        The plan, and what `assemble` made of it with the bands of `bands_wanted`.
    settings
        What was asked for.
    denoise
        Whether pictures are denoised (`denoise.wants_denoising`, asked before the render changes the scene's settings).
    suffix
        Of the files' names, for a further view layer.
    """
    smooth = denoised(render.xyz, render.guide) if denoise else None
    return write_outputs(
        directory, plan, render, settings, space=blend_space(), denoised_xyz=smooth, suffix=suffix
    )
