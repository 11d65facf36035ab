"""How the sample capture of the gym is made: the spectra, the hall, the renders, the camera."""
