"""Test films under a display matrix, written with PyAV alone."""

from __future__ import annotations

from itertools import product

import av
import cv2
import numpy as np

ONE = 1 << 16
UPRIGHT = [(a * ONE, 0, 0, 0, d * ONE, 0, 0, 0, 1 << 30) for a, d in product((1, -1), repeat=2)]
ON_ITS_SIDE = [(0, b * ONE, 0, c * ONE, 0, 0, 0, 0, 1 << 30) for b, c in product((1, -1), repeat=2)]
SIZE = (320, 180)


def marked_picture(colour_corner=(0, 0, 220)) -> np.ndarray:
    """Letters that cannot be mistaken for their mirror image, and one coloured corner."""
    picture = np.full((SIZE[1], SIZE[0], 3), 90, np.uint8)
    cv2.putText(picture, "FRG", (70, 120), cv2.FONT_HERSHEY_SIMPLEX, 3, (230, 230, 230), 9, cv2.LINE_AA)
    picture[:40, :60] = colour_corner
    return cv2.GaussianBlur(picture, (0, 0), 1.5)


def write_turned(path, matrix=None):
    """A film of the marked picture under a display matrix, FFmpeg's nine numbers."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=25, options={"crf": "8"})
        stream.width, stream.height, stream.pix_fmt = *SIZE, "yuv420p"
        stream.codec_context.colorspace = stream.codec_context.color_range = 1
        if matrix is not None:
            stream.set_display_matrix(matrix)
        for k in range(5):
            frame = av.VideoFrame.from_ndarray(marked_picture(), format="bgr24")
            frame = frame.reformat(format="yuv420p", dst_colorspace="ITU709")
            frame.pts = k
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    return path
