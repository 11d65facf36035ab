"""The words of the command line that say what a spectral render writes."""

from __future__ import annotations

import argparse

from .render.outputs import OutputSettings, output_settings


def add_output_words(parser: argparse._ActionsContainer) -> None:
    """Add --spectral, --white, --denoise and --no-denoise."""
    parser.add_argument(
        "--spectral", action="store_true", help="also write all 61 wavelengths, spectral.exr (Fichet et al.)"
    )
    parser.add_argument(
        "--white",
        default="",
        metavar="WHITE",
        help="adapt image.exr and rgb.exr from this white to D65: an illuminant (A, D50, FL2), a temperature (5000K) or x,y "
        "(default: no adaptation)",
    )
    parser.add_argument(
        "--denoise",
        action=argparse.BooleanOptionalAction,
        default=None,
        help="denoise the assembled image (default: as the scene says)",
    )


def output_settings_of(arguments: argparse.Namespace) -> OutputSettings:
    """The output settings of parsed words.

    Raises
    ------
    SpectralDataError
        If the white is not known.
    """
    return output_settings(spectral=arguments.spectral, white=arguments.white, denoise=arguments.denoise)
