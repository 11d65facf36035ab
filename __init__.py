"""Spectral Probe: the spectrum of the light around a mirrored ball, and spectral rendering with it in Cycles.

Blender calls `register` and `unregister`. The submodules are imported there and not above, so that Python
tools that meet this file as the parent of `spectral_probe` (the plain core) never need Blender.
"""


def register() -> None:
    """Make the settings, operators and panels known to Blender."""
    from . import operators, panels, preferences, properties, versions

    for part in (preferences, properties, operators, panels, versions):
        part.register()


def unregister() -> None:
    """Take everything back, last first."""
    from . import operators, panels, preferences, properties, versions

    for part in (versions, panels, operators, properties, preferences):
        part.unregister()
