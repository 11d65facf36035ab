"""The capture file (TOML): what was photographed, with what, from where.

Every key is checked: an unknown one is named, with the nearest known one beside it. Paths are relative to the file.
"""

from __future__ import annotations

import difflib
import math
import tomllib
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from ..errors import CaptureError
from ..model import COMPOSITIONS, BallSettings, CameraSettings, Capture, ViewSettings
from .atomic import written_whole
from .spectrum_file import is_spectrum_file

type Table = Mapping[str, Any]

_CAMERA_KEYS = (
    "model", "sensitivities", "focal_px", "focal_mm", "sensor_width_mm", "calibration", "principal_px", "distortion",
    "half_size",
)  # fmt: skip
_BALL_KEYS = ("radius_m", "material")
_LIGHT_KEYS = ("families", "method")
_PANORAMA_KEYS = ("composition",)
_VIEW_KEYS = (
    "azimuth_deg", "elevation_deg", "roll_deg", "refine", "photos", "exposures_s", "iso", "f_number", "outline",
    "ball_at", "solve_exposures",
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
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise CaptureError(f"There is no capture file at {path}. Check the path.") from None
    except (OSError, UnicodeDecodeError) as problem:
        raise CaptureError(f"{path} cannot be read ({problem}). Give a capture file in TOML.") from None
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as problem:
        raise CaptureError(f"{path.name} is not valid TOML: {problem}. Correct that line.") from None
    return parse_capture(document, path.parent, path.name)


def parse_capture(document: Table, folder: Path, name: str = "the capture") -> Capture:
    """A capture from a TOML document already read; paths are taken relative to `folder`."""
    reader = _Reader(name, folder)
    reader.check_keys(document, ("camera", "ball", "light", "panorama", "view"), "the capture file")
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
        families=reader.families(light),
        method=reader.text(light, "method", "[light]") or "family",
        composition=reader.composition(reader.table(document, "panorama", _PANORAMA_KEYS)),
    )


class _Reader:
    """Typed values out of TOML tables, with error messages that name the place."""

    def __init__(self, name: str, folder: Path) -> None:
        self.name = name
        self.folder = folder

    def fail(self, where: str, key: str, wanted: str) -> CaptureError:
        return CaptureError(f"{self.name}, {where}: {key} must be {wanted}.")

    def check_keys(self, table: Table, known: Collection[str], where: str) -> None:
        for key in table:
            if key not in known:
                near = difflib.get_close_matches(key, known, n=1)
                hint = f'Did you mean "{near[0]}"?' if near else f"Known are {', '.join(known)}."
                raise CaptureError(f'{self.name}, {where}: there is no key "{key}". {hint}')

    def table(self, document: Table, key: str, known: Collection[str]) -> Table:
        table = document.get(key, {})
        if not isinstance(table, Mapping):
            raise CaptureError(f"{self.name}: write [{key}] once, as a table.")
        self.check_keys(table, known, f"[{key}]")
        return table

    def number(self, table: Table, key: str, where: str, *, positive: bool = False) -> float | None:
        value = table.get(key)
        if value is None:
            return None
        if not _is_number(value) or (positive and value <= 0):
            raise self.fail(where, key, "a positive number" if positive else "a number")
        return float(value)

    def truth(self, table: Table, key: str, where: str, *, default: bool) -> bool:
        value = table.get(key, default)
        if not isinstance(value, bool):
            raise self.fail(where, key, "true or false")
        return value

    def composition(self, table: Table) -> str:
        value = self.text(table, "composition", "[panorama]") or COMPOSITIONS[0]
        if value not in COMPOSITIONS:
            raise self.fail("[panorama]", "composition", " or ".join(f'"{name}"' for name in COMPOSITIONS))
        return value

    def text(self, table: Table, key: str, where: str) -> str | None:
        value = table.get(key)
        if value is not None and not isinstance(value, str):
            raise self.fail(where, key, "text in quotes")
        return value

    def file(self, table: Table, key: str, where: str, *, or_folder: bool = False) -> Path | None:
        value = self.text(table, key, where)
        return None if value is None else self.existing(value, where, or_folder=or_folder)

    def existing(self, value: str, where: str, *, or_folder: bool = False) -> Path:
        path = self.folder / value
        if not (path.is_file() or (or_folder and path.is_dir())):
            raise CaptureError(f"{self.name}, {where}: there is no file {path}. Check the name.")
        return path

    def numbers(
        self, table: Table, key: str, where: str, lengths: Collection[int], *, positive: bool = False
    ) -> tuple[float, ...] | None:
        value = table.get(key)
        if value is None:
            return None
        if (
            not isinstance(value, list)
            or len(value) not in lengths
            or not all(_is_number(item) for item in value)
        ):
            raise self.fail(where, key, f"a list of {' or '.join(map(str, sorted(lengths)))} numbers")
        if positive and any(item <= 0 for item in value):
            raise self.fail(where, key, "a list of positive numbers")
        return tuple(float(item) for item in value)

    def camera(self, table: Table) -> CameraSettings:
        where = "[camera]"
        focal = table.get("focal_px")
        if _is_number(focal):
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
            if not material or not all(_is_number(value) and value > 0 for value in material.values()):
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

    def families(self, table: Table) -> tuple[str, ...]:
        value = table.get("families", ["incandescent", "daylight"])
        value = [value] if isinstance(value, str) else value
        if not isinstance(value, list) or not value or not all(isinstance(item, str) for item in value):
            raise self.fail(
                "[light]", "families", 'a list of lamp families such as ["incandescent", "daylight"]'
            )
        return tuple(value)

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
        outline = self.numbers(table, "outline", where, {3})
        if outline is not None and outline[2] <= 0:
            raise self.fail(where, "outline", "[cx_px, cy_px, r_px] with a positive radius")

        def per_photo(key: str) -> tuple[float, ...] | None:
            value = table.get(key)
            source = (
                {key: [value] * len(photos)} if _is_number(value) else table
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
            outline=None if outline is None else (outline[0], outline[1], outline[2]),
            ball_at=None if ball_at is None else (ball_at[0], ball_at[1]),
            solve_exposures=self.truth(table, "solve_exposures", where, default=True),
        )


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def save_capture(capture: Capture, path: Path) -> None:
    """Write a capture file that `load_capture` reads back the same; paths become relative to it where they can."""
    path = Path(path)
    folder = path.resolve().parent
    camera, ball = capture.camera, capture.ball
    lines = ["[camera]"]
    lines += _entries(
        model=camera.model,
        sensitivities=_relative(camera.sensitivities, folder),
        focal_px=camera.focal_px,
        focal_mm=camera.focal_mm,
        sensor_width_mm=camera.sensor_width_mm,
        calibration=_relative(camera.calibration, folder),
        principal_px=camera.principal_px,
        distortion=camera.distortion if any(camera.distortion) else None,
        half_size=camera.half_size or None,
    )
    lines += ["", "[ball]", *_entries(radius_m=ball.radius_m, material=_material(ball.material, folder))]
    lines += ["", "[light]", *_entries(families=capture.families, method=capture.method)]
    lines += ["", "[panorama]", *_entries(composition=capture.composition)]
    for view in capture.views:
        lines += ["", "[[view]]"]
        lines += _entries(
            azimuth_deg=view.azimuth_deg,
            elevation_deg=view.elevation_deg,
            roll_deg=view.roll_deg or None,
            refine=view.refine,
            photos=tuple(_relative(photo, folder) for photo in view.photos),
            exposures_s=view.exposures_s,
            iso=view.iso,
            f_number=view.f_number,
            outline=view.outline,
            ball_at=view.ball_at,
            solve_exposures=None if view.solve_exposures else False,
        )
    with written_whole(path) as temporary:
        temporary.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _material(material: str | Mapping[str, float], folder: Path) -> str | Mapping[str, float] | None:
    """A ball's material, the path of a measured one relative to the capture file where it can be."""
    is_file = isinstance(material, str) and is_spectrum_file(material)
    return _relative(Path(str(material)), folder) if is_file else material


def _relative(path: Path | None, folder: Path) -> str | None:
    if path is None:
        return None
    path = Path(path).resolve()
    return path.relative_to(folder).as_posix() if path.is_relative_to(folder) else path.as_posix()


def _entries(**values: object) -> list[str]:
    return [f"{key} = {_toml(value)}" for key, value in values.items() if value is not None]


def _toml(value: object) -> str:
    match value:
        case bool():
            return "true" if value else "false"
        case float() | int():
            return repr(value)
        case tuple():
            return f"[{', '.join(map(_toml, value))}]"
        case Mapping():
            return f"{{ {', '.join(f'{_toml(str(key))} = {_toml(item)}' for key, item in value.items())} }}"
        case _:
            escaped = str(value).replace("\\", "\\\\").replace('"', '\\"')
            return f'"{escaped}"'
