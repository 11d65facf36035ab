"""Spectral light from photographs of a mirrored ball: the core, plain numpy without Blender.

The folders follow the pipeline of Tominaga & Tanaka, "Spectral Measurement of Omnidirectional
Light Distribution and Its Application to Image Rendering": `photo` (photographs to radiance),
`geometry` (the ball, directions, the panorama; eq. 1-6), `spectra` (spectral recovery; eq. 7-11),
`render` (plans of Cycles passes, passes to tristimulus values, comparison; eq. 12), `files` and `figures`.
"""
