"""The fillers alone, through the same small interface that plugins get."""

import cv2
import numpy as np
import pytest
from attrs import field, frozen
from hypothesis import given
from hypothesis import strategies as st
from plain_context import SIZE, PlainContext, grey

from mcsl_core.filling.footprint import FootprintFiller
from mcsl_core.filling.layers import mask_rects
from mcsl_core.filling.paper import PaperFiller
from mcsl_core.filling.viewpoint import viewpoint_difference
from mcsl_core.imaging.planes import Planes
from mcsl_core.imaging.rect import Rect
from mcsl_core.timing import FrameRange


def row_of(context, filler=None):
    return (filler or FootprintFiller(16)).fill(context).y[96].astype(int)


def test_others_stand_behind_in_order_softly_and_the_rest_is_black():
    columns = {"ref": (0, 200), "near": (100, 260), "far": (200, 300)}
    context = PlainContext(columns, {"ref": 100, "near": 180, "far": 60}, "near")
    filled = FootprintFiller(feather_px=16).fill(context)
    row = filled.y[96].astype(int)
    assert (row[:98] == 100).all()
    assert (row[120:240] == 180).all()
    assert (row[264:292] == 60).all()  # nearly to its edge: nothing stands behind that it would have to fade into
    assert (row[302:] == 16).all()
    assert (np.diff(row[96:122]) >= 0).all()  # a soft edge, no dark seam
    assert np.abs(np.diff(row[96:122])).max() < 20
    assert (np.diff(row[290:304]) <= 0).all()  # and into what nobody sees, smoothly
    assert (row[:296] > 55).all()
    assert (filled.u == 128).all()


def test_nothing_to_fill_gives_the_same_object_and_asks_nobody():
    context = PlainContext({"a": (0, 320), "b": (0, 320)}, {"a": 90, "b": 10}, "a")
    front = context.front
    context.asked.clear()
    filled = FootprintFiller().fill(context)
    assert np.array_equal(filled.y, front.y)
    assert {camera for camera, *_ in context.asked} == {"a"}


def test_dark_pictures_are_no_holes():
    context = PlainContext({"ref": (0, 320), "a": (60, 320)}, {"ref": 100, "a": 16}, "a")
    assert (row_of(context)[100:] == 16).all()


def test_a_camera_that_adds_nothing_is_not_asked():
    context = PlainContext({"a": (0, 200), "b": (0, 320), "c": (0, 320)}, {"a": 90, "b": 120, "c": 50}, "a")
    FootprintFiller().fill(context)
    assert "c" not in {camera for camera, *_ in context.asked}


def test_one_camera_beside_the_chosen_is_decoded_all_along():
    columns = {"ref": (0, 200), "a": (100, 260), "b": (0, 280), "c": (200, 320)}
    context = PlainContext(columns, {"ref": 100, "a": 180, "b": 90, "c": 60}, "a")
    row_of(context)
    assert {camera for camera, median_of, _ in context.asked if not median_of} == {"a", "ref"}
    alone = PlainContext({"ref": (0, 260), "b": (100, 264), "c": (200, 320)}, {"ref": 100, "b": 90, "c": 60}, "ref")
    row_of(alone)
    assert {camera for camera, median_of, _ in alone.asked if not median_of} == {
        "ref",
        "b",
    }  # nearest that adds enough


def test_medians_leave_out_who_was_in_the_way_and_change_slowly():
    """A rim that only c sees; c is hidden by something white at two of the grid's frames."""

    def c(frame):
        return 235 if frame in (1000, 1200) else 60 + frame // 200

    columns = {"ref": (0, 200), "a": (60, 200), "c": (150, 320)}
    rims = []
    for frame in range(1190, 1420):
        context = PlainContext(columns, {"ref": 100, "a": 180, "c": c}, "a", frame=frame)
        rims.append(row_of(context)[280])
    assert max(rims) < 70
    assert np.abs(np.diff(rims)).max() <= 1
    assert len(set(rims)) > 1


def test_what_no_camera_sees_now_comes_from_other_poses_more_blurred_with_age():
    before, here, after = FrameRange(0, 900), FrameRange(1000, 2000), FrameRange(2100, 3000)
    columns = {"ref": (0, 240), "a": (60, 240)}
    values = {"ref": lambda f: 100 + f // 1000 * 30, "a": 180}
    poses = ((before, {"ref": (40, 290)}), (here, {}), (after, {"ref": (0, 320)}))
    early, late = (PlainContext(columns, values, "a", frame=f, poses=poses) for f in (1010, 1990))
    for context in (early, late):
        row = row_of(context)
        assert (row[252:270] == 100).all()  # the pose before saw it
        assert (row[300:] == 160).all()  # only the pose after did
    blur = [
        max(b for camera, median_of, b in v.asked if camera == "ref" and median_of and median_of[0] in before)
        for v in (early, late)
    ]
    assert 0 < blur[0] < blur[1]
    unseen = PlainContext(columns, values, "a", frame=1010, poses=((here, {}),))
    assert (row_of(unseen)[250:] == 16).all()  # nothing is invented


@pytest.mark.parametrize("frame", [0, 7, 95, 104, 1234])
def test_a_frame_depends_on_its_number_alone(frame):
    columns = {"ref": (0, 200), "a": (60, 200), "c": (150, 320)}
    values = {"ref": 100, "a": 180, "c": lambda f: 40 + f % 97}
    used = FootprintFiller(16)
    for other in range(max(0, frame - 12), frame):
        used.fill(PlainContext(columns, values, "a", frame=other))
    again = used.fill(PlainContext(columns, values, "a", frame=frame))
    alone = FootprintFiller(16).fill(PlainContext(columns, values, "a", frame=frame))
    assert np.array_equal(again.y, alone.y)


def test_a_camera_without_picture_lets_the_next_shine_through():
    columns = {"a": (0, 200), "b": (0, 320), "c": (0, 320)}
    row = row_of(PlainContext(columns, {"a": 90, "b": None, "c": 50}, "a"))
    assert (row[220:] == 50).all()
    gap = PlainContext({"a": (0, 200), "b": (0, 260), "c": (0, 320)}, {"a": 90, "b": None, "c": None}, "a")
    row = row_of(gap)
    assert (row[210:] == 16).all()
    assert (row[:190] == 90).all()


@pytest.mark.parametrize("seed", range(5))
def test_rectangles_hold_what_is_not_the_front_alone_and_are_even_and_apart(seed):
    rng = np.random.default_rng(seed)
    masks = [np.ones((135, 240), bool), np.zeros((135, 240), bool), np.zeros((135, 240), bool)]
    for mask in masks[1:]:
        for _ in range(4):
            x, y = rng.integers(0, 200), rng.integers(0, 120)
            mask[y : y + rng.integers(3, 60), x : x + rng.integers(3, 60)] = True
    masks[0][:40, :60] = False
    masks[1][:40, :60] = True
    covered = np.zeros((270, 480), int)
    for rect, members in mask_rects(masks):
        assert not any(v % 2 for v in (rect.x, rect.y, rect.width, rect.height))
        assert rect.x + rect.width <= 480
        part = (slice(rect.y // 2, (rect.y + rect.height) // 2), slice(rect.x // 2, (rect.x + rect.width) // 2))
        assert members == tuple(i for i, mask in enumerate(masks) if mask[part].any())
        covered[rect.y : rect.y + rect.height, rect.x : rect.x + rect.width] += 1
    assert covered.max() <= 1
    assert (covered[::2, ::2][masks[1] | masks[2] | ~masks[0]] == 1).all()
    assert covered.mean() < 0.9
    assert mask_rects([np.ones((10, 10), bool)]) == []


# ------------------------------------------------------------------------------------------------------ the paper's


def papers(front, reference, previous):
    """The formulas as the paper's text has them, on the luma plane, in plain cv2 and numpy.

    Value 10 of 255 is luma 26 rounded: 16 + 10.5 * 219 / 255 is the least that exceeds it.
    """
    exceeds = np.round((front.astype(float) - 16) * 255 / 219) > 10
    alpha = cv2.GaussianBlur(np.where(exceeds, 1.0, 0.0), (49, 49), 0)
    blended = alpha * front + (1 - alpha) * reference
    missing = np.round((np.round(blended) - 16) * 255 / 219) <= 10
    return np.where(missing, cv2.GaussianBlur(previous, (9, 9), 0), blended), missing, np.abs(blended - 25.5) > 1.5


def test_the_papers_filler_is_the_papers():
    rng = np.random.default_rng(5)
    noise = cv2.resize(rng.integers(18, 220, (12, 20), np.uint8), SIZE, interpolation=cv2.INTER_CUBIC)

    def textured(left, right, shift):
        y = np.full(SIZE[::-1], 16, np.uint8)
        y[:, left:right] = np.roll(noise, shift, axis=1)[:, left:right]
        return Planes(y, grey(0).u, grey(0).v)

    pictures = {"ref": textured(0, 250, 40), "a": textured(80, 200, 0)}

    class Textured(PlainContext):
        def picture(self, camera, rect, median_of=(), blur_px=0.0, *, parallax_corrected=False):
            return rect.of(pictures[camera])

    context = Textured({"ref": (0, 250), "a": (80, 200)}, {}, "a", previous=textured(0, 320, 90))
    expected, missing, sure = papers(pictures["a"].y, pictures["ref"].y, context.previous.y)
    found = PaperFiller().fill(context).y
    assert missing[:, 260:].all()
    assert sure.mean() > 0.98  # elsewhere rounding decides what counts as missing
    difference = np.abs(found - expected)[sure]
    assert difference.max() <= 2  # alpha has 8 bits, and each blend rounds
    assert difference.mean() < 0.5


def test_the_papers_filler_blends_by_brightness():
    context = PlainContext({"ref": (0, 320), "a": (100, 320)}, {"ref": 100, "a": 180}, "a")
    row = PaperFiller().fill(context).y[96].astype(int)
    assert np.abs(row[:70] - 100).max() <= 1
    assert np.abs(row[130:] - 180).max() <= 1
    dark = PlainContext(
        {"ref": (0, 320), "a": (0, 320)}, {"ref": 100, "a": 18}, "a"
    )  # below 10 of 255 counts as missing
    assert np.abs(PaperFiller().fill(dark).y.astype(int) - 100).max() <= 1


def test_the_papers_filler_blurs_what_it_keeps_the_more_the_older_it_is():
    columns = {"ref": (0, 240), "a": (0, 240)}
    stripes = grey(16)
    stripes.y[:, ::8] = 200
    previous, contrast = stripes, []
    for _ in range(4):
        previous = PaperFiller().fill(PlainContext(columns, {"ref": 100, "a": 100}, "a", previous=previous))
        contrast.append(previous.y[96, 280:310].std())
    assert contrast[0] > contrast[1] >= contrast[2] >= contrast[3]
    assert contrast[3] < contrast[0] / 2


# ------------------------------------------------------------------------------------------- difference of viewpoint


def seen_from(camera_mm, focal=900.0):
    """Plane z = 0 in mm to pixels of a camera at that place which looks at the origin."""
    at = np.array(camera_mm, float)
    z = -at / np.linalg.norm(at)
    x = np.cross([0.3, 1.0, 0.1], z)
    x /= np.linalg.norm(x)
    rotation = np.stack([x, np.cross(z, x), z])
    intrinsics = np.array([[focal, 0, 480], [0, focal, 270], [0, 0, 1.0]])
    return intrinsics @ np.column_stack([rotation[:, 0], rotation[:, 1], rotation @ -at])


@given(turn=st.floats(-3.1, 3.1), zoom=st.floats(0.5, 2), x=st.floats(-300, 300), y=st.floats(-300, 300))
def test_turn_zoom_and_shift_are_one_viewpoint(turn, zoom, x, y):
    c, s = zoom * np.cos(turn), zoom * np.sin(turn)
    a = seen_from((200, 100, 1000))
    b = np.array([[c, -s, x], [s, c, y], [0, 0, 1]]) @ a
    assert viewpoint_difference(np.linalg.inv(a), np.linalg.inv(b), (960, 540)) < 1e-9


@given(angle=st.floats(0.05, 1.4), more=st.floats(0.05, 1.4), turn=st.floats(-3, 3))
def test_further_round_the_lamp_is_further_apart(angle, more, turn):
    def camera(a):
        return np.linalg.inv(seen_from((300 * np.cos(a), 300 * np.sin(a), 1000)))

    front, near, far = camera(turn), camera(turn + angle), camera(turn + angle + more)
    assert viewpoint_difference(front, near, (960, 540)) < viewpoint_difference(front, far, (960, 540))


# ------------------------------------------------------------------------------------------------ who is in the way


@frozen(eq=False)
class Watched(PlainContext):
    """Each camera has somebody in rectangles (x, y, right, bottom) of the programme; its medians do not."""

    people: dict = field(factory=dict)

    def change(self, camera, median_of):
        cells = np.zeros((SIZE[1] // 16, SIZE[0] // 16), np.float32)
        for x, y, right, bottom in self.people.get(camera, ()):
            cells[y // 16 : -(-bottom // 16), x // 16 : -(-right // 16)] = 80
        return cells

    def picture(self, camera, rect, median_of=(), blur_px=0.0, *, parallax_corrected=False):
        planes = PlainContext.picture(self, camera, Rect(0, 0, *SIZE), median_of, blur_px)
        if not median_of:
            for x, y, right, bottom in self.people.get(camera, ()):
                planes.y[y:bottom, x:right] = 220
        return rect.of(planes)


def watched(people, camera="a"):
    columns = {"ref": (0, 320), "a": (96, 320)}
    context = Watched(columns, {"ref": 100, "a": 180}, camera, people=people)
    return FootprintFiller(16).fill(context).y.astype(int)


def test_a_head_that_only_the_other_camera_sees_does_not_come_back_at_the_edge():
    head = (32, 48, 160, 144)
    assert np.abs(watched({"ref": [head]})[:, :90] - 100).max() <= 3


def test_hands_that_both_cameras_see_stay():
    filled = watched({"ref": [(32, 64, 160, 112)], "a": [(104, 64, 176, 112)]})
    assert (filled[70:106, 40:88] > 200).all()
    assert np.abs(filled[:56, :90] - 100).max() <= 3


def test_somebody_whom_nothing_tells_apart_stays():
    """Far from the chosen camera's picture: whether it is a head or a tray is not known, and nothing is taken away."""
    assert (watched({"ref": [(0, 64, 24, 112)]})[70:106, 4:20] > 200).all()


def test_being_in_the_way_comes_gradually():
    rows = []
    for reach in range(48, 177, 16):
        rows.append(watched({"ref": [(16, 48, reach, 144)]})[96, 40])
    assert rows[0] > 200  # beside the chosen camera's picture
    assert rows[-1] < 110
    assert all(b <= a + 2 for a, b in zip(rows, rows[1:], strict=False))
