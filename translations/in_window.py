"""What the core says to people at a command line or before a capture file, said to those before a window.

By templates, as translations are: `{0}`, ... is what the core puts in. A test ties them to the core.
"""

IN_WINDOW = {
    "The scene has no backplate, so nothing says which photograph is meant. Give one: --plate PHOTO, or "
    "Photograph in the Composite panel.": (
        "The scene has no backplate, so nothing says which photograph is meant. Choose one: Photograph in "
        "the panel Composite."
    ),
    "{0} is a converted picture, the photographs of the ball are raw, so its response curve is missing. "
    "Give the plate as raw, or take it as plain sRGB with --response srgb.": (
        "{0} is a converted picture, the photographs of the ball are raw, so its response curve is missing. "
        "Choose the plate as raw, or switch on Plain sRGB."
    ),
    "{0} says no exposure time, and shows too little in common with the photographs of the ball to tell "
    "it. Give --exposure-s, and --iso and --f-number where they differ.": (
        "{0} says no exposure time, and shows too little in common with the photographs of the ball to tell "
        "it. Give Exposure in the panel Backplate, and ISO and F-Number where they differ."
    ),
    "{0} is camera raw, and nothing says how the camera sees colours. Give --camera, a name of `library "
    "list camera` or a file of its sensitivities.": (
        "{0} is camera raw, and nothing says how the camera sees colours. Give Camera in the panel "
        "Composite: a name of the library, or a file of its sensitivities."
    ),
    "{0} is a converted picture, and its response curve is missing: give --response srgb, or the "
    "report.json of a probe built from the same camera's converted pictures.": (
        "{0} is a converted picture, and its response curve is missing. Switch on Plain sRGB."
    ),
    "{0} says no exposure time. Give --exposure-s beside --iso and --f-number.": (
        "{0} says no exposure time. Give it as Exposure."
    ),
    "{0} does not say its focal length. Add focal_px, or focal_mm and sensor_width_mm, to [camera] in "
    "the capture file.": (
        "{0} does not say its focal length. Give Focal Length in World > Spectral Probe > Capture > Camera."
    ),
    "{0} has a focal length of {1} mm, but nothing says how large the sensor is. Add sensor_width_mm, or "
    "focal_px, to [camera] in the capture file.": (
        "{0} has a focal length of {1} mm, but nothing says how large the sensor is. Give Sensor Width, or "
        "the focal length in pixels, in World > Spectral Probe > Capture > Camera."
    ),
    "{0}: a focal length of {1} px for an image {2} px wide is not possible (from {3}). Correct "
    "focal_px, or focal_mm and sensor_width_mm.": (
        "{0}: a focal length of {1} px for an image {2} px wide is not possible (from {3}). Correct Focal "
        "Length or Sensor Width in World > Spectral Probe > Capture > Camera."
    ),
    "{0}: focal lengths of {1} and {2} px along x and y differ too much. Correct focal_px.": (
        "{0}: focal lengths of {1} and {2} px along x and y differ too much. Correct Focal Length in World > "
        "Spectral Probe > Capture > Camera."
    ),
    "{0}: the principal point {1}, {2} lies too far outside of the image of {3} x {4} pixels. Correct "
    "principal_px.": (
        "{0}: the principal point {1}, {2} lies too far outside of the image of {3} x {4} pixels. Correct "
        "Principal Point in World > Spectral Probe > Capture > Camera."
    ),
    "The camera would stand {0} m below the ground. Correct elevation_deg of the view in the capture "
    "(above 0 the camera looks down), or say how far below the ball the ground is.": (
        "The camera would stand {0} m below the ground. Correct the Elevation of the view (above 0 the "
        "camera looks down), or Ground Below in the panel Backplate."
    ),
    "{0} holds a value that is not positive. Correct it in the capture file.": (
        "{0} holds a value that is not positive. Correct the exposure in World > Spectral Probe > Capture > "
        "Photographs."
    ),
    "{0}: {1} s at ISO {2} and f/{3} cannot be. Correct the exposure in the capture file.": (
        "{0}: {1} s at ISO {2} and f/{3} cannot be. Correct the exposure in World > Spectral Probe > Capture "
        "> Photographs."
    ),
    "The view has no photographs. List them as photos in the capture file.": (
        "The view has no photographs. Add some, or remove the view."
    ),
    'There is no camera called "{0}" in the library. {1}Known are {2}; or give a file of your camera: '
    'sensitivities = "camera.csv".': (
        'There is no camera called "{0}" in {1}. {2}Choose one from the list of the field Camera.'
    ),
    "{0} is camera raw, so its camera must be known. Add to [camera] a model ({1}) or sensitivities = "
    '"camera.csv".': (
        "{0} is camera raw, so its camera must be known. Choose Camera ({1}), or a file of its "
        "Sensitivities, in World > Spectral Probe > Capture > Camera."
    ),
    "Nothing in this render can be exchanged. Make a region swappable (--swappable), or measured lamps "
    "(--swappable-lamps), and render again.": (
        "Nothing in this render can be exchanged. Make a region swappable, or switch on Lamps Too, in the "
        "panel Swap Light, and render again."
    ),
    "[calibration] names view {0}, but there are {1}. Correct view.": (
        "The view {0} in the panel Calibration is not there: there are {1}. Correct View."
    ),
    "[calibration]: view {0} was taken through a filter. Name a view without one.": (
        "View {0}, given in the panel Calibration, was taken through a filter. Choose a view without one."
    ),
    "[calibration]: the patch is uneven ({0}): part of it may not be the known light. Check its place.": (
        "Calibration: the patch is uneven ({0}): part of it may not be the known light. Check its place."
    ),
    "[calibration] gives gains of {0}, 1 and {1} for red, green and blue: check the place and the "
    "spectrum of the known light.": (
        "Calibration gives gains of {0}, 1 and {1} for red, green and blue: check the place and the spectrum "
        "of the known light."
    ),
    "[calibration]: no view sees light_at well enough in the ball. Check its bearing and elevation.": (
        "Calibration: no view sees the known light well enough in the ball. Check its Bearing and Elevation."
    ),
    "[calibration]: the card of {0} is black: it shows no light. Use a grey one.": (
        "Calibration: the card of {0} is black: it shows no light. Use a grey one."
    ),
    "[calibration]: the ball would reflect more than all of the light; it was taken to reflect all. "
    "Check the patches.": (
        "Calibration: the ball would reflect more than all of the light; it was taken to reflect all. Check "
        "the patches."
    ),
    "The card is black in a channel, in the ball or seen directly. Give ball_patch_px and patch_px on "
    "the card.": (
        "The card is black in a channel, in the ball or seen directly. Correct Patch and Reflection in the "
        "panel Calibration."
    ),
    "The ball returns {0}, {1} and {2} of the card's red, green and blue: no smooth reflectance does "
    "that. Check ball_patch_px and patch_px.": (
        "The ball returns {0}, {1} and {2} of the card's red, green and blue: no smooth reflectance does "
        "that. Check Patch and Reflection in the panel Calibration."
    ),
    "{0} needs one of polygon_deg, mask and seed_deg to say where it is.": (
        "{0} does not say where it is. Give its corners, a mask or a direction."
    ),
    "{0}: polygon_deg needs three corners or more, [bearing, elevation] each.": (
        "{0}: a polygon needs three corners or more, bearing and elevation of each."
    ),
}
