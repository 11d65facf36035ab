"""The capture file (TOML): what was photographed, with what, from where.

Every key is checked: an unknown one is named, with the nearest known one beside it. Paths are relative to the file.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..errors import CaptureError
from ..model import COMPOSITIONS, BallSettings, CameraSettings, Capture, ViewSettings
from .atomic import written_whole
from .capture_light import (
    FAMILIES_WANTED,
    calibration_lines,
    filter_text,
    read_calibration,
    read_filter,
    read_regions,
    region_lines,
)
from .spectrum_file import is_spectrum_file
from .toml import Table, TomlReader, entries, is_number, relative

_MOST_BYTES = 16_000_000

_CAMERA_KEYS = (
    "model", "sensitivities", "focal_px", "focal_mm", "sensor_width_mm", "calibration", "principal_px", "distortion",
    "half_size",
)  # fmt: skip
_BALL_KEYS = ("radius_m", "material")
_LIGHT_KEYS = ("method", "families", "spectra")
_PANORAMA_KEYS = ("composition",)
_VIEW_KEYS = (
    "azimuth_deg", "elevation_deg", "roll_deg", "refine", "photos", "exposures_s", "iso", "f_number", "outline",
    "ball_at", "solve_exposures", "filter", "snap_outline",
)  # fmt: skip


def load_capture(path: Path) -> Capture:
    """Read a capture file.

    Raises
    ------
    CaptureError
        If the file is missing, is not TOML, has a key it should not have, a value of the wrong kind, no view, or names a
        file that does not exist.
    """
    path = Path(path)
    try:
        if path.exists() and not path.is_file():  # a pipe would be waited for
            raise CaptureError(f"{path} cannot be read: it is no file. Give a capture file in TOML.")
        if path.stat().st_size > _MOST_BYTES:
            raise CaptureError(f"{path.name} is too large to be a capture file. Give another.")
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise CaptureError(f"There is no capture file at {path}. Check the path.") from None
    except (OSError, UnicodeDecodeError) as problem:
        raise CaptureError(f"{path} cannot be read ({problem}). Give a capture file in TOML.") from None
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as problem:
        raise CaptureError(f"{path.name} is not valid TOML: {problem}. Correct that line.") from None
    except (RecursionError, ValueError):  # thousands of brackets, or of digits
        raise CaptureError(
            f"{path.name} holds a list too deep or a number too long to be meant. Correct it."
        ) from None
    return parse_capture(document, path.parent, path.name)


def parse_capture(document: Table, folder: Path, name: str = "the capture") -> Capture:
    """A capture from a TOML document already read; paths are taken relative to `folder`."""
    reader = _Reader(name, folder)
    tables = ("camera", "ball", "light", "calibration", "panorama", "view", "region")
    reader.check_keys(document, tables, "the capture file")
    views = document.get("view", [])
    if isinstance(views, Mapping):
        raise CaptureError(f"{name} has [view] in single brackets. Write [[view]] for each view.")
    if not isinstance(views, list) or not views:
        raise CaptureError(f"{name} has no view. Add a [[view]] with its photos.")
    light = reader.table(document, "light", _LIGHT_KEYS)
    return Capture(
        views=tuple(reader.view(view, number) for number, view in enumerate(views, start=1)),
        camera=reader.camera(reader.table(document, "camera", _CAMERA_KEYS)),
        ball=reader.ball(reader.table(document, "ball", _BALL_KEYS)),
        families=reader.texts(light, "families", "[light]", FAMILIES_WANTED) or Capture.families,
        method=reader.text(light, "method", "[light]") or "family",
        composition=reader.composition(reader.table(document, "panorama", _PANORAMA_KEYS)),
        spectra=reader.spectra(light),
        regions=read_regions(reader, document),
        calibration=read_calibration(reader, document),
    )


class _Reader(TomlReader):
    """The tables of a capture file."""

    def composition(self, table: Table) -> str:
        value = self.text(table, "composition", "[panorama]") or COMPOSITIONS[0]
        if value not in COMPOSITIONS:
            raise self.fail("[panorama]", "composition", " or ".join(f'"{name}"' for name in COMPOSITIONS))
        return value

    def camera(self, table: Table) -> CameraSettings:
        where = "[camera]"
        focal = table.get("focal_px")
        if is_number(focal):
            table = {**table, "focal_px": [focal, focal]}
        focal_px = self.numbers(table, "focal_px", where, {2}, positive=True)
        principal_px = self.numbers(table, "principal_px", where, {2})
        return CameraSettings(
            model=self.text(table, "model", where),
            sensitivities=self.file(table, "sensitivities", where, or_folder=True),
            focal_px=None if focal_px is None else (focal_px[0], focal_px[1]),
            focal_mm=self.number(table, "focal_mm", where, positive=True),
            sensor_width_mm=self.number(table, "sensor_width_mm", where, positive=True),
            calibration=self.file(table, "calibration", where),
            principal_px=None if principal_px is None else (principal_px[0], principal_px[1]),
            distortion=self.numbers(table, "distortion", where, {4, 5, 8}) or (0.0,) * 5,
            half_size=self.truth(table, "half_size", where, default=False),
        )

    def ball(self, table: Table) -> BallSettings:
        where, default = "[ball]", BallSettings()
        material = table.get("material", default.material)
        if isinstance(material, Mapping):
            if not material or not all(is_number(value) and value > 0 for value in material.values()):
                raise self.fail(
                    where,
                    "material",
                    "a name, or positive fractions of metals such as { Fe = 0.74, Cr = 0.26 }",
                )
            material = {str(metal): float(value) for metal, value in material.items()}
        elif not isinstance(material, str):
            raise self.fail(
                where, "material", "a name, or fractions of metals such as { Fe = 0.74, Cr = 0.26 }"
            )
        elif is_spectrum_file(material):
            material = str(self.existing(material, where))
        return BallSettings(
            self.number(table, "radius_m", where, positive=True) or default.radius_m, material
        )

    def spectra(self, table: Table) -> tuple[Path, ...]:
        names = self.texts(table, "spectra", "[light]", 'a list of files such as ["mylamp.csv"]')
        return tuple(self.existing(name, "[light]") for name in names or ())

    def view(self, table: Any, number: int) -> ViewSettings:
        where = f"[[view]] {number}"
        if not isinstance(table, Mapping):
            raise self.fail("the capture file", "view", "written as [[view]]")
        self.check_keys(table, _VIEW_KEYS, where)
        photos = table.get("photos")
        if not isinstance(photos, list) or not photos or not all(isinstance(photo, str) for photo in photos):
            raise self.fail(where, "photos", 'a list of file names such as ["v0_0.dng", "v0_1.dng"]')
        elevation = self.number(table, "elevation_deg", where) or 0.0
        if not -90.0 <= elevation <= 90.0:
            raise self.fail(where, "elevation_deg", "between -90 and 90")
        ball_at = self.numbers(table, "ball_at", where, {2})
        outline = self.numbers(table, "outline", where, {3, 5})
        if outline is not None and min(outline[2:4]) <= 0:
            raise self.fail(
                where,
                "outline",
                "[cx_px, cy_px, r_px] with a positive radius, or [cx_px, cy_px, a_px, b_px, angle_deg]",
            )

        def per_photo(key: str) -> tuple[float, ...] | None:
            value = table.get(key)
            source = (
                {key: [value] * len(photos)} if is_number(value) else table
            )  # one number stands for every photo
            return self.numbers(source, key, where, {len(photos)}, positive=True)

        return ViewSettings(
            photos=tuple(self.existing(photo, where) for photo in photos),
            azimuth_deg=self.number(table, "azimuth_deg", where) or 0.0,
            elevation_deg=elevation,
            roll_deg=self.number(table, "roll_deg", where) or 0.0,
            refine=self.truth(table, "refine", where, default=True),
            exposures_s=per_photo("exposures_s"),
            iso=per_photo("iso"),
            f_number=per_photo("f_number"),
            outline=outline,
            ball_at=None if ball_at is None else (ball_at[0], ball_at[1]),
            solve_exposures=self.truth(table, "solve_exposures", where, default=True),
            filter=read_filter(self, table, where),
            snap_outline=self.truth(table, "snap_outline", where, default=False),
        )


def save_capture(capture: Capture, path: Path) -> None:
    """Write a capture file that `load_capture` reads back the same; paths become relative to it where they can."""
    path = Path(path)
    folder = path.resolve().parent
    camera, ball = capture.camera, capture.ball
    lines = ["[camera]"]
    lines += entries(
        model=camera.model,
        sensitivities=relative(camera.sensitivities, folder),
        focal_px=camera.focal_px,
        focal_mm=camera.focal_mm,
        sensor_width_mm=camera.sensor_width_mm,
        calibration=relative(camera.calibration, folder),
        principal_px=camera.principal_px,
        distortion=camera.distortion if any(camera.distortion) else None,
        half_size=camera.half_size or None,
    )
    lines += ["", "[ball]", *entries(radius_m=ball.radius_m, material=_material(ball.material, folder))]
    spectra = tuple(relative(path, folder) for path in capture.spectra) or None
    light = entries(method=capture.method, families=capture.families, spectra=spectra)
    lines += ["", "[light]", *light]
    if capture.calibration is not None:
        lines += ["", *calibration_lines(capture.calibration, folder)]
    lines += ["", "[panorama]", *entries(composition=capture.composition)]
    for view in capture.views:
        lines += ["", "[[view]]"]
        lines += entries(
            azimuth_deg=view.azimuth_deg,
            elevation_deg=view.elevation_deg,
            roll_deg=view.roll_deg or None,
            refine=view.refine,
            photos=tuple(relative(photo, folder) for photo in view.photos),
            exposures_s=view.exposures_s,
            iso=view.iso,
            f_number=view.f_number,
            outline=view.outline,
            snap_outline=view.snap_outline or None,
            ball_at=view.ball_at,
            solve_exposures=None if view.solve_exposures else False,
            filter=filter_text(view.filter, folder),
        )
    for region in capture.regions:
        lines += ["", *region_lines(region, folder)]
    with written_whole(path) as temporary:
        temporary.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _material(material: str | Mapping[str, float], folder: Path) -> str | Mapping[str, float] | None:
    """A ball's material, the path of a measured one relative to the capture file where it can be."""
    is_file = isinstance(material, str) and is_spectrum_file(material)
    return relative(Path(str(material)), folder) if is_file else material
