"""Spectral Probe: the spectrum of the light around a mirrored ball, and spectral rendering with it in Cycles.

Blender calls `register` and `unregister`. The submodules are imported there and not above, so that Python
tools that meet this file as the parent of `spectral_probe` (the plain core) never need Blender.
"""


def register() -> None:
    """Make the settings, operators and panels known to Blender."""
    from . import file_handlers, operators, panels, preferences, properties, translations

    for part in (translations, preferences, properties, operators, panels, file_handlers):
        part.register()


def unregister() -> None:
    """Take everything back, last first."""
    from . import file_handlers, operators, panels, preferences, properties, translations

    for part in (file_handlers, panels, operators, properties, preferences, translations):
        part.unregister()
