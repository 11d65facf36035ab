"""Spectral data and spectral recovery (eq. 7-11)."""
