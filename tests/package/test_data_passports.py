"""Every data file says in SOURCES.toml what it is, its unit, its licence and where it comes from."""

import tomllib
from pathlib import Path

KEYS = {"quantity", "unit", "range", "licence", "source"}


def complaints(folder: Path) -> list[str]:
    """What is wrong with the passports of a data folder."""
    passports_file = folder / "SOURCES.toml"
    passports = tomllib.loads(passports_file.read_text("utf-8")) if passports_file.is_file() else {}
    files = {
        path.relative_to(folder).as_posix()
        for path in folder.rglob("*")
        if path.is_file()
        and path != passports_file
        and "__pycache__" not in path.parts
        and path.suffix != ".py"
    }
    found = [f"{name} has no entry in SOURCES.toml" for name in sorted(files - passports.keys())]
    found += [f"SOURCES.toml names {name}, which is not there" for name in sorted(passports.keys() - files)]
    for name in sorted(files & passports.keys()):
        missing = sorted(key for key in KEYS if not str(passports[name].get(key, "")).strip())
        found += [f"the entry of {name} lacks {', '.join(missing)}"] if missing else []
    return found


def test_every_data_file_has_a_passport(project_root):
    assert complaints(project_root / "spectral_probe" / "data") == []


def test_what_is_missing_is_noticed(tmp_path):
    (tmp_path / "glass.csv").write_text("wavelength_nm,transmittance\n")
    (tmp_path / "lamp.csv").write_text("wavelength_nm,radiance\n")
    (tmp_path / "SOURCES.toml").write_text(
        '["lamp.csv"]\nquantity = "radiance"\nunit = "1"\nrange = "400-700 nm"\nsource = "us"\n'
        '["gone.csv"]\nquantity = "n"\n'
    )
    assert complaints(tmp_path) == [
        "glass.csv has no entry in SOURCES.toml",
        "SOURCES.toml names gone.csv, which is not there",
        "the entry of lamp.csv lacks licence",
    ]
