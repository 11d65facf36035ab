"""Endings of the names of photographs: known without opening a file, and without any library.

The first ending of a kind is the one that is proposed to whoever has to rename a file.
"""

JPEG = (".jpg", ".jpeg", ".jpe", ".jfif")
PNG = (".png",)
TIFF = (".tif", ".tiff")
OPEN_EXR = (".exr",)
RADIANCE_HDR = (".hdr", ".pic", ".rgbe")
RAW = (
    ".3fr", ".arw", ".cr2", ".cr3", ".crw", ".dcr", ".dng", ".erf", ".fff", ".gpr", ".iiq", ".kdc", ".mef", ".mos", ".mrw",
    ".nef", ".nrw", ".orf", ".pef", ".raf", ".raw", ".rw2", ".rwl", ".sr2", ".srf", ".srw", ".x3f",
)  # fmt: skip
"""What LibRaw reads."""

PHOTOGRAPHS = (*RAW, *JPEG, *PNG, *TIFF, *OPEN_EXR, *RADIANCE_HDR)
