"""What the user knows of the light: regions of a panorama with lights of their own, and the known light to calibrate by."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from .errors import CaptureError


@dataclass(frozen=True)
class Region:
    """Some directions of a panorama; exactly one of the three is given.

    `polygon_deg` holds the corners (compass bearing, elevation) in degrees of a polygon whose edges are great circles, the
    smaller side of it; `mask` is an equirectangular picture, white inside (row 0 is up, as the panorama); `seed_deg` is a
    bearing and elevation in one bright thing, such as a window, that the region grows over.
    """

    polygon_deg: tuple[tuple[float, float], ...] | None = None
    mask: Path | None = None
    seed_deg: tuple[float, float] | None = None


@dataclass(frozen=True)
class RegionLight:
    """`[[region]]` of a capture file: what light a region has, by lamp families or by a measured `spectrum` (CSV)."""

    region: Region
    families: tuple[str, ...] | None = None
    spectrum: Path | None = None

    def check(self, where: str) -> None:
        """Refuse what contradicts itself; `where` names the region in the message.

        Raises
        ------
        CaptureError
        """
        places = (self.region.polygon_deg, self.region.mask, self.region.seed_deg)
        if sum(place is not None for place in places) != 1:
            raise CaptureError(f"{where} needs one of polygon_deg, mask and seed_deg to say where it is.")
        if self.region.polygon_deg is not None and len(self.region.polygon_deg) < 3:
            raise CaptureError(
                f"{where}: polygon_deg needs three corners or more, [bearing, elevation] each."
            )
        if (self.families is None) == (self.spectrum is None):
            raise CaptureError(f"{where} needs either families or a measured spectrum, not both.")


type Rectangle = tuple[float, float, float, float]
"""Left, upper, right and lower edge in pixels of a photograph."""


@dataclass(frozen=True)
class CalibrationSettings:
    """`[calibration]` of a capture file: one known light, and where it is seen.

    Either `light_at` (compass bearing and elevation in degrees of a lamp or card that the ball mirrors) or `patch_px` (a card
    or lamp seen directly in the first photograph of view number `view`, counted from 1) says where. Either `spectrum` (a
    measured one, CSV) or the name of an `illuminant` says what light it is, and `reflectance` (a number or a CSV) how much of it
    the card returns. With `absolute` the spectrum is the radiance, in W m^-2 sr^-1 nm^-1, of the lamp itself, or of a perfectly
    white card in that light. `ball_patch_px` is where the ball mirrors the card of `patch_px`.
    """

    light_at: tuple[float, float] | None = None
    patch_px: Rectangle | None = None
    view: int = 1
    spectrum: Path | None = None
    illuminant: str | None = None
    reflectance: float | Path = 1.0
    absolute: bool = False
    ball_patch_px: Rectangle | None = None

    def check(self) -> None:
        """Refuse what contradicts itself.

        Raises
        ------
        CaptureError
        """
        if (self.light_at is None) == (self.patch_px is None):
            raise CaptureError(
                "[calibration] needs either light_at = [bearing, elevation] or patch_px = [x0, y0, x1, y1], not both."
            )
        if (self.spectrum is None) == (self.illuminant is None):
            raise CaptureError(
                '[calibration] needs either spectrum = "lamp.csv" or illuminant = "A", and not both.'
            )
        if self.absolute and self.spectrum is None:
            raise CaptureError(
                "[calibration]: absolute = true needs a spectrum measured in W m^-2 sr^-1 nm^-1. Give spectrum, or leave "
                "absolute out."
            )
        if not isinstance(self.reflectance, Path) and not 0.0 < self.reflectance <= 1.0:
            raise CaptureError(
                f"[calibration]: a card's reflectance lies above 0 and up to 1 (a grey card's is 0.18), not at "
                f"{self.reflectance:g}."
            )
        if self.ball_patch_px is not None and self.patch_px is None:
            raise CaptureError(
                "[calibration]: ball_patch_px is compared with the card seen directly. Give patch_px as well."
            )
        for name, patch in (("patch_px", self.patch_px), ("ball_patch_px", self.ball_patch_px)):
            if patch is not None and not (patch[0] < patch[2] and patch[1] < patch[3]):
                raise CaptureError(
                    f"[calibration]: {name} must be [x0, y0, x1, y1] in pixels with x0 < x1 and y0 < y1."
                )
        if self.light_at is not None and not -90.0 <= self.light_at[1] <= 90.0:
            raise CaptureError("[calibration]: the elevation in light_at must be between -90 and 90 degrees.")
