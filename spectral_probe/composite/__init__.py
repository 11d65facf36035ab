"""Augmented reality: objects rendered spectrally, put into a photograph by differential rendering (Debevec 1998)."""
