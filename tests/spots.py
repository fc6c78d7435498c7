"""Clips of white spots, and where they lie in a picture: found without anything of mcsl's or Blender's geometry."""

from __future__ import annotations

import cv2
import numpy as np
from blender_recording import RATE

from mcsl_core.media.writing import Encoding, VideoWriter

SPOTS = np.array([[60, 40], [260, 50], [80, 140], [230, 130], [160, 90], [120, 70]], float)


def spots(path, size, points):
    """A clip of white discs, radius 5, on black."""
    image = np.zeros((size[1], size[0], 3), np.uint8)
    for x, y in points:
        cv2.circle(image, (round(x * 16), round(y * 16)), 5 * 16, (255, 255, 255), -1, cv2.LINE_AA, shift=4)
    encoding = Encoding(options={"preset": "ultrafast", "crf": "4"})
    with VideoWriter(path, size=size, rate=RATE, encoding=encoding, keyframe_interval=1) as writer:
        for _ in range(4):
            writer.write(image)


def middles(luma):
    """The centroid of each bright spot, in pixels, sub-pixel by brightness."""
    count, labels = cv2.connectedComponents((luma > 40).astype(np.uint8))
    found = []
    for label in range(1, count):
        rows, columns = np.nonzero(labels == label)
        weight = luma[rows, columns].astype(float)
        if weight.sum() > 2000:
            found.append([(columns * weight).sum() / weight.sum(), (rows * weight).sum() / weight.sum()])
    return np.array(found)


def projected(matrix, points):
    moved = np.c_[points, np.ones(len(points))] @ np.asarray(matrix).T
    return moved[:, :2] / moved[:, 2:]
