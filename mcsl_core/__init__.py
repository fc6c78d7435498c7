"""mcsl: one steady, unoccluded video from the cameras of a surgical lamp.

The pipeline that turns a recording into an edit-decision list (EDL) and the EDL into programme pictures.
Nothing in this package imports Blender; importing the package itself imports nothing heavy.
"""

__version__ = "0.1.0"
