"""What fields offer while a name is typed into them: entries of the library, with what they are beside them.

Free text stays allowed. Blender itself drops candidates whose name, not description, lacks what was typed, so a metal is offered
in English too. The libraries behind load when somebody types, not when Blender starts.
"""

from collections.abc import Iterable

import bpy

from ..preferences import library_folder

type Candidates = list[tuple[str, str]]

_FEWEST_LETTERS = (
    3  # before all of refractiveindex.info is searched: two letters are in thousands of its pages
)
_MOST = 200  # candidates; a longer menu helps nobody


def camera_names(_group: bpy.types.PropertyGroup, _context: bpy.types.Context, typed: str) -> Candidates:
    """Cameras of the library and of the user's folder."""
    from ..spectral_probe.spectra.camera import camera_names as known
    from ..spectral_probe.spectra.camera import cameras_in

    folder = library_folder()
    own = [] if folder is None else [(name, path.name) for name, path in cameras_in(folder).items()]
    return _matching([*own, *((name, "") for name in known())], typed)


def ball_materials(_group: bpy.types.PropertyGroup, _context: bpy.types.Context, typed: str) -> Candidates:
    """Balls known by name, then metals, then pages of refractiveindex.info."""
    from ..spectral_probe.spectra.metals import BALL_MATERIALS

    balls = [
        (
            name,
            " + ".join(f"{fraction:g} {metal}" for metal, fraction in fractions.items())
            if len(fractions) > 1
            else "",
        )
        for name, fractions in BALL_MATERIALS.items()
    ]
    return [*_matching(balls, typed), *(entry for entry in _metals(typed) if entry[0] not in BALL_MATERIALS)]


def metal_names(_group: bpy.types.PropertyGroup, _context: bpy.types.Context, typed: str) -> Candidates:
    """Metals known by name, then pages of refractiveindex.info."""
    return _metals(typed)


def reflectance_names(_group: bpy.types.PropertyGroup, _context: bpy.types.Context, typed: str) -> Candidates:
    """Measured surfaces of the library and of the user's folder."""
    from ..spectral_probe.spectra.catalogue import catalogue

    return _matching([(entry.name, "") for entry in catalogue("reflectance", library_folder())], typed)


def lamp_names(_group: bpy.types.PropertyGroup, _context: bpy.types.Context, typed: str) -> Candidates:
    """Lamps of the library, with their families. Any temperature may be typed: "Planck 3200 K"."""
    from ..spectral_probe.spectra.catalogue import catalogue

    return _matching([(entry.name, entry.family) for entry in catalogue("lamp")], typed)


def glass_names(_group: bpy.types.PropertyGroup, _context: bpy.types.Context, typed: str) -> list[str]:
    """Stained glasses that come with the extension."""
    from ..spectral_probe.spectra.glass import GLASSES

    return [name for name in GLASSES if typed.casefold() in name.casefold()]


def clear_material_names(
    _group: bpy.types.PropertyGroup, _context: bpy.types.Context, typed: str
) -> Candidates:
    """Clear materials known by name, then pages of refractiveindex.info."""
    from ..spectral_probe.spectra.dispersion import CLEAR_PAGES

    return [*_matching(CLEAR_PAGES.items(), typed), *_pages(typed)]


def _metals(typed: str) -> Candidates:
    from ..spectral_probe.spectra.metals import METAL_NAMES, METAL_PAGES

    named = [
        (word, METAL_PAGES[symbol]) for symbol, word in METAL_NAMES.items() if word.lower() != symbol.lower()
    ]
    return [*_matching([*METAL_PAGES.items(), *named], typed), *_pages(typed)]


def _pages(typed: str) -> Candidates:
    """Pages of refractiveindex.info."""
    from ..spectral_probe.spectra.refractive import ENGLISH, search_pages

    if len(typed.strip()) < _FEWEST_LETTERS:
        return []
    pages = [
        (
            f"{ENGLISH[page.book]}: {page.name}" if page.book in ENGLISH else page.name,
            page.remark or page.title,
        )
        for page in search_pages(typed.split())
    ]
    return pages[:_MOST]


def _matching(candidates: Iterable[tuple[str, str]], typed: str) -> Candidates:
    """Candidates that have every word typed in their name or in what they are."""
    words = typed.casefold().split()
    return [entry for entry in candidates if all(word in " ".join(entry).casefold() for word in words)]
