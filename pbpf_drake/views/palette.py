"""The colors of estimates, detections and the truth, wherever they are drawn.

The same thing has two shades, as what is behind it differs: Meshcat's white
background, or a camera's image. ``*_RGBA`` are for Meshcat. ``*_BGR`` are for
images: blue, green, red, from 0 to 255.
"""

from pydrake.geometry import Rgba

ESTIMATE_RGBA = Rgba(0.1, 0.75, 0.3)
DETECTION_RGBA = Rgba(1.0, 0.8, 0.0)
TRUTH_RGBA = Rgba(0.1, 0.3, 1.0)
# What a model doesn't give a color.
PLAIN_RGBA = Rgba(0.9, 0.9, 0.9)

ESTIMATE_BGR = (90, 224, 25)
DETECTION_BGR = (0, 213, 255)
# The robot and everything fixed.
SURROUNDINGS_BGR = (110, 110, 110)
# Instead of a camera's image, where there is none.
BACKGROUND_BGR = (40, 40, 40)
