"""The part of the capture file that says what is known of the light: filters, regions, calibration."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..errors import CaptureError
from ..light_settings import CalibrationSettings, Rectangle, Region, RegionLight
from .toml import Table, TomlReader, entries, is_number, relative

FAMILIES_WANTED = 'a list of lamp families such as ["incandescent", "daylight"]'

_REGION_KEYS = ("polygon_deg", "mask", "seed_deg", "families", "spectrum")
_CALIBRATION_KEYS = (
    "light_at", "patch_px", "view", "spectrum", "illuminant", "reflectance", "absolute", "ball_patch_px",
)  # fmt: skip


def read_regions(reader: TomlReader, document: Table) -> tuple[RegionLight, ...]:
    """Every `[[region]]`."""
    tables = document.get("region", [])
    if not isinstance(tables, list):
        raise CaptureError(
            f"{reader.name} has [region] in single brackets. Write [[region]] for each region."
        )
    return tuple(_region(reader, table, number) for number, table in enumerate(tables, start=1))


def _region(reader: TomlReader, table: Any, number: int) -> RegionLight:
    where = f"[[region]] {number}"
    if not isinstance(table, Mapping):
        raise reader.fail("the capture file", "region", "written as [[region]]")
    reader.check_keys(table, _REGION_KEYS, where)
    region = Region(
        reader.pairs(table, "polygon_deg", where),
        reader.file(table, "mask", where),
        reader.pair(table, "seed_deg", where),
    )
    families = reader.texts(table, "families", where, FAMILIES_WANTED)
    light = RegionLight(region, families, reader.file(table, "spectrum", where))
    light.check(f"{reader.name}, {where}")
    return light


def read_calibration(reader: TomlReader, document: Table) -> CalibrationSettings | None:
    """The `[calibration]`, None where there is none."""
    where = "[calibration]"
    table = reader.table(document, "calibration", _CALIBRATION_KEYS)
    if "calibration" not in document:
        return None
    view = table.get("view", 1)
    if not isinstance(view, int) or isinstance(view, bool) or view < 1:
        raise reader.fail(where, "view", "the number of a view: 1 for the first")
    calibration = CalibrationSettings(
        light_at=reader.pair(table, "light_at", where),
        patch_px=_rectangle(reader, table, "patch_px"),
        view=view,
        spectrum=reader.file(table, "spectrum", where),
        illuminant=reader.text(table, "illuminant", where),
        reflectance=_reflectance(reader, table),
        absolute=reader.truth(table, "absolute", where, default=False),
        ball_patch_px=_rectangle(reader, table, "ball_patch_px"),
    )
    calibration.check()
    return calibration


def _rectangle(reader: TomlReader, table: Table, key: str) -> Rectangle | None:
    value = reader.numbers(table, key, "[calibration]", {4})
    return None if value is None else (value[0], value[1], value[2], value[3])


def _reflectance(reader: TomlReader, table: Table) -> float | Path:
    value = table.get("reflectance", 1.0)
    if isinstance(value, str):
        return reader.existing(value, "[calibration]")
    if not is_number(value):
        raise reader.fail("[calibration]", "reflectance", "a number such as 0.18, or a CSV file")
    return float(value)


def read_filter(reader: TomlReader, table: Table, where: str) -> str | Path | None:
    """`filter` of a view: a transmittance file, or the name of a glass, which is looked up when it is needed."""
    value = reader.text(table, "filter", where)
    if value is None:
        return None
    path = reader.folder / value
    return reader.existing(value, where) if Path(value).suffix or path.is_file() else value


def filter_text(value: str | Path | None, folder: Path) -> str | None:
    """A filter as it is written in a capture file in `folder`."""
    return relative(value, folder) if isinstance(value, Path) else value


def region_lines(light: RegionLight, folder: Path) -> list[str]:
    """A `[[region]]` as it is written."""
    region = light.region
    return [
        "[[region]]",
        *entries(
            polygon_deg=region.polygon_deg,
            mask=relative(region.mask, folder),
            seed_deg=region.seed_deg,
            families=light.families,
            spectrum=relative(light.spectrum, folder),
        ),
    ]


def calibration_lines(calibration: CalibrationSettings, folder: Path) -> list[str]:
    """The `[calibration]` as it is written."""
    reflectance = calibration.reflectance
    return [
        "[calibration]",
        *entries(
            light_at=calibration.light_at,
            patch_px=calibration.patch_px,
            view=calibration.view if calibration.view != 1 else None,
            spectrum=relative(calibration.spectrum, folder),
            illuminant=calibration.illuminant,
            reflectance=relative(reflectance, folder) if isinstance(reflectance, Path) else reflectance,
            absolute=calibration.absolute or None,
            ball_patch_px=calibration.ball_patch_px,
        ),
    ]
