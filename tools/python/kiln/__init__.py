"""Kiln: pictures of volumes larger than memory.

    import kiln
    s = kiln.open("head.kiln")                 # a store, a volume file, or an array
    im = s.render(view="front", tf="ct-bone", size=(640, 480))
    im.save("head.png")

Voxels have the axes z, y, x: shapes, boxes, slices and spacings. An affine takes the voxel (x, y, z, 1) to the
world (x, y, z). Words of pictures are those of the command `kiln render --help`: --sample-distance is sample_distance.
The manual's page is python.md.
"""

from kiln._kiln import Error, Warning, version as __version__
from kiln._convert import convert
from kiln._functions import TransferFunction, transfer_function
from kiln._image import Image
from kiln._jobs import Frames, render
from kiln._viewer import Viewer, view
from kiln._volume import Volume, open
from kiln._words import options

__all__ = [
    "Error",
    "Frames",
    "Image",
    "TransferFunction",
    "Viewer",
    "Volume",
    "Warning",
    "convert",
    "open",
    "options",
    "render",
    "transfer_function",
    "view",
]
