"""Photographs to radiance: reading, exposure, alignment, merging."""
