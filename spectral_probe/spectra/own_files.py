"""Entries of the library that are the user's own files: what a file holds, told by its columns and its name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from ..errors import SpectralDataError
from ..files.spectrum_file import first_columns, is_spectrum_file, read_samples
from ..model import FloatArray
from .camera import camera_name, camera_sensitivities, gains_remark, has_three_channels
from .curves import LIGHT, REFLECTANCE, SENSITIVITY, TRANSMITTANCE, SampledCurves, checked, on_grid
from .passports import Passport

_QUANTITIES: Mapping[str, str] = {
    "lamp": LIGHT, "reflectance": REFLECTANCE, "ball": REFLECTANCE, "glass": TRANSMITTANCE, "camera": SENSITIVITY,
}  # fmt: skip
"""What is measured of each kind."""

_WORDS: Mapping[str, tuple[str, ...]] = {
    "glass": ("transmi", "glass", "filter"),
    "reflectance": ("reflect", "albedo", "patch", "ball"),
}
"""Words in a heading or in a file's name that tell a kind; a lamp where there is none of them."""


@dataclass(frozen=True)
class OwnEntry:
    """One file, and its passport."""

    passport: Passport
    path: Path

    def curves(self) -> dict[str, FloatArray]:
        """Its curves on the exchange grid, (61,) each, by the name of what they are."""
        kind = self.passport.kind
        if kind == "camera":
            return dict(zip("rgb", camera_sensitivities(file=self.path).T, strict=True))
        curve = on_grid(first_columns(read_samples(self.path), 1), _QUANTITIES[kind])[0]
        return {"relative_power" if kind == "lamp" else _QUANTITIES[kind]: curve}

    def as_tabulated(self) -> tuple[FloatArray, FloatArray]:
        """Wavelengths and values of its first curve as the file has them, noise taken off."""
        samples = checked(first_columns(read_samples(self.path), 1), _QUANTITIES[self.passport.kind])
        return samples.wavelengths_nm, samples.values[0]


def own_entry(path: Path, kind: str | None = None) -> OwnEntry:
    """The entry that a file makes.

    Parameters
    ----------
    path
        A file of `spectrum_file.read_samples`.
    kind
        What it is, a word of `passports.KINDS`; seen from its columns and names by default.

    Raises
    ------
    SpectralDataError
        If the file cannot be read, or cannot be of that kind.
    """
    samples = read_samples(path)
    kind = kind or _kind(samples, path)
    if kind not in _QUANTITIES:
        raise SpectralDataError(
            f"A file of your own cannot be shown as a {kind}. Kinds are {', '.join(_QUANTITIES)}."
        )
    remark = None
    if kind == "camera":
        remark = gains_remark(camera_name(samples, path), camera_sensitivities(file=path))
    else:
        on_grid(first_columns(samples, 1), _QUANTITIES[kind])
    passport = Passport(
        camera_name(samples, path) if kind == "camera" else path.stem,
        kind,
        f"own file {path.name}",
        f"relative spectral {SENSITIVITY}" if kind == "camera" else _QUANTITIES[kind],
        "1, relative" if kind in {"camera", "lamp"} else "1, fraction",
        *samples.range_nm,
        samples.licence or "the user's own",
        samples.source or path.name,
        remark or "",
    )
    return OwnEntry(passport, path)


def own_entries(folder: Path) -> tuple[list[OwnEntry], list[str]]:
    """Entries of the files in a folder, and a sentence on each file that cannot be used.

    Raises
    ------
    SpectralDataError
        If it is no folder.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise SpectralDataError(f"There is no folder {folder}. Check the path.")
    entries, complaints = [], []
    for path in sorted(folder.iterdir(), key=lambda path: path.name.casefold()):
        if path.is_file() and is_spectrum_file(path.name):
            try:
                entries.append(own_entry(path))
            except SpectralDataError as problem:
                complaints.append(str(problem))
    return entries, complaints


def _kind(samples: SampledCurves, path: Path) -> str:
    if has_three_channels(samples):
        return "camera"
    words = f"{samples.columns[0]} {path.stem}".casefold()
    return next((kind for kind, told in _WORDS.items() if any(word in words for word in told)), "lamp")
