"""Swatches in Blender: the list that panels show, and an icon for every entry."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

import bpy

if TYPE_CHECKING:
    from ...spectral_probe.spectra.swatches import Swatch

_SIDE_PX = 16
_EDGE = 0.55  # of the swatch's colour: bright ones must be seen on bright themes
_FEWEST_LETTERS = 3  # before all of refractiveindex.info is searched
_MOST_PAGES = 100  # of each kind; a longer list helps nobody


class SwatchShelf:
    """What was computed last, and its icons, until the extension is switched off.

    Icons belong to Blender, not to a file: they outlive the opening of another.
    """

    _icons: ClassVar[Any] = None
    _named: ClassVar[tuple[Swatch, ...]] = ()
    _pages: ClassVar[tuple[Swatch, ...]] = ()

    @classmethod
    def fill(
        cls, listed: bpy.types.PropertyGroup, named: tuple[Swatch, ...], pages: tuple[Swatch, ...], light: str
    ) -> None:
        """Show swatches: the library's own entries, and pages once they are searched for."""
        cls._named, cls._pages = named, pages
        listed.light = light
        cls.list_matching(listed, listed.search)

    @classmethod
    def list_matching(cls, listed: bpy.types.PropertyGroup, typed: str) -> None:
        """List what has every word typed, the library's own entries first."""
        from ...spectral_probe.spectra.swatches import matching

        shown = [*matching(cls._named, typed)]
        if len(typed.strip()) >= _FEWEST_LETTERS:
            pages = matching(cls._pages, typed)
            for kind in ("METAL", "DISPERSIVE"):
                shown += [page for page in pages if page.kind == kind][:_MOST_PAGES]
        listed.items.clear()
        for swatch in shown:
            item = listed.items.add()
            item.name, item.kind, item.entry = swatch.key, swatch.kind, swatch.name
            item.label, item.detail, item.source = swatch.label, swatch.detail, swatch.source
            item.licence, item.remark = swatch.licence, swatch.remark
            cls._draw(swatch)

    @classmethod
    def icon_of(cls, key: str) -> int:
        """Number of an entry's icon for `icon_value`; 0 where it has none."""
        icon = cls._icons.get(key) if cls._icons is not None else None
        return icon.icon_id if icon is not None else 0

    @classmethod
    def clear(cls) -> None:
        """Give everything back."""
        if cls._icons is not None:
            import bpy.utils.previews

            bpy.utils.previews.remove(cls._icons)
        cls._icons, cls._named, cls._pages = None, (), ()

    @classmethod
    def _draw(cls, swatch: Swatch) -> None:
        """Fill the entry's icon; one that is there already changes its colour."""
        import bpy.utils.previews
        import numpy as np

        if cls._icons is None:
            cls._icons = bpy.utils.previews.new()
        icon = cls._icons.get(swatch.key) or cls._icons.new(swatch.key)
        pixels = np.ones((_SIDE_PX, _SIDE_PX, 4), np.float32)
        pixels[..., :3] = np.array(swatch.rgb) * _EDGE
        pixels[1:-1, 1:-1, :3] = swatch.rgb
        packed = np.rint(pixels * 255).astype(np.uint8).view(np.int32).ravel()
        icon.icon_size = (_SIDE_PX, _SIDE_PX)
        icon.icon_pixels.foreach_set(packed)
