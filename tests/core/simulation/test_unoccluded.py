"""The truth that fills are measured by: the empty room as the reference camera sees it, on a wider image plane."""

import attrs
import numpy as np
import pytest
from pictures import psnr

from mcsl_core.simulation import Scenario
from mcsl_core.simulation.clocks import clocks
from mcsl_core.simulation.ground import Ground
from mcsl_core.simulation.render import CameraPictures
from mcsl_core.simulation.scene import Scene
from mcsl_core.simulation.unoccluded import UnoccludedScene

pytestmark = pytest.mark.slow  # two scenes are painted
SCENARIO = Scenario(seed=312, size=(320, 180), duration_s=12, cameras=2, movements=((6, 1),), noise=0.0)


@pytest.fixture(scope="module")
def scene():
    return UnoccludedScene(SCENARIO)


def test_it_is_what_the_reference_camera_films_in_an_empty_room(scene):
    quiet = attrs.evolve(SCENARIO, heads=0, hands=0)
    simulated = Scene.of(quiet)
    pictures = CameraPictures(simulated, Ground.of(quiet, simulated.surface, simulated.rig), 0, clocks(quiet)[0])
    rate = float(SCENARIO.rate)
    filmed = pictures.frame(60)[0]
    # COARSE grids of rays are the same; the field's states are cut out of one map or laid in it first: a code or two.
    assert psnr(filmed.y, scene.at(60 / rate).y) > 45
    assert psnr(filmed.v, scene.at(60 / rate).v) > 45
    moved = pictures.frame(round(10 * rate))[0]
    assert psnr(moved.y, scene.at(10.0).y) < 30  # the lamp has moved; the scene's perspective has not


def test_shifted_it_shows_the_same_and_more(scene):
    here, shifted = scene.at(2.0), scene.at(2.0, (40.0, -20.0))
    assert psnr(here.y[20:, :-40], shifted.y[:-20, 40:]) > 38
    assert shifted.y[:, :40].std() > 5  # and beyond the camera's own picture the room goes on
    assert np.abs(shifted.y[:-20, 38:42].astype(int) - here.y[20:, 0:1]).mean() < 12
