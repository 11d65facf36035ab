"""Camera, ball, directions and the panorama (eq. 1-6)."""
