"""From EDL and .blend to video, read back by PyAV: every preset, both engines, and plain `blender -b FILE -a`."""

from __future__ import annotations

import subprocess
from pathlib import Path

import attrs
import av
import numpy as np
import pytest
from blender_recording import FRAMES, RATE, R, an_edl, ground_of, in_blender, number_of
from traces import traces

from mcsl_core import edl as edls
from mcsl_core.blender.render import render
from mcsl_core.blender.timeline import build_timeline
from mcsl_core.delivery import presets
from mcsl_core.edl import Override
from mcsl_core.errors import Cancelled, InputError, UsageError
from mcsl_core.progress import Silent

BT709, LIMITED = 1, 1  # ITU-T H.273
SHOWN = ["cam1"] * 20 + ["cam2"] * 20 + ["cam3"] * 5 + ["cam1"] * 5 + ["cam3"] * 10  # an_edl, its override included


def lumas(path: Path) -> list[np.ndarray]:
    """Every frame's luma, 8 bits."""
    with av.open(str(path)) as container:
        return [f.reformat(format="yuv420p").to_ndarray()[: f.height].copy() for f in container.decode(video=0)]


def heard_in(path: Path) -> np.ndarray:
    """The left channel, -1 to 1, from the first sample."""
    sound = np.zeros(0)
    with av.open(str(path)) as container:
        resampler = av.AudioResampler(format="fltp", rate=48000)
        for frame in container.decode(audio=0):
            for made in resampler.resample(frame):
                start, data = max(0, round(made.time * 48000)), made.to_ndarray()[0]
                sound = np.concatenate([sound[:start], np.zeros(max(0, start - len(sound))), data])
    return sound


def psnr(a: np.ndarray, b: np.ndarray) -> float:
    error = np.mean((a.astype(float) - b.astype(float)) ** 2)
    return float("inf") if error == 0 else float(10 * np.log10(255**2 / error))


def matrix_of(stream) -> tuple[int, int]:
    return stream.codec_context.colorspace, stream.codec_context.color_range


EXPECTED = {
    "review": ("h264", (160, 90), "aac"),
    "h264": ("h264", (320, 180), "aac"),
    "h265": ("hevc", (320, 180), "aac"),
    "prores": ("prores", (320, 180), "pcm_s16le"),
    "archive": ("ffv1", (320, 180), "flac"),
}


@pytest.mark.parametrize("engine", ["blender", "direct"])
@pytest.mark.parametrize("name", sorted(EXPECTED))
def test_each_preset(project, blender, name, engine):
    preset = presets.load_preset(name)
    out = project / f"out.{preset.container}"
    render(project / "edl.json", out, preset=name, engine=engine, blender=blender)
    codec, size, sound = EXPECTED[name]
    with av.open(str(out)) as container:
        video, audio = container.streams.video[0], container.streams.audio[0]
        assert video.codec_context.name == codec
        assert (video.width, video.height) == size
        assert video.average_rate == RATE
        assert audio.codec_context.name == sound
        assert (audio.sample_rate, audio.channels) == (48000, 2)
        if codec in ("h264", "hevc"):
            assert matrix_of(video) == (BT709, LIMITED)
        if codec == "hevc":
            assert video.codec_context.codec_tag == "hvc1"  # Apple's players take no hev1
        if codec == "prores":
            assert video.codec_context.pix_fmt == "yuv422p10le"
            assert video.codec_context.profile == "HQ"
        told = {**container.metadata, **video.metadata}
        assert not [v for v in told.values() if "edl" in v or str(project) in v or "202" in v]  # no path, no date
        heard = np.concatenate([f.to_ndarray().astype(float).ravel() for f in container.decode(audio=0)])
        assert np.abs(heard).max() > 0
    assert traces(out) == []  # nor what its encoders were told
    frames = lumas(out)
    assert [number_of(luma) for luma in frames] == list(range(FRAMES))
    assert [ground_of(luma) for luma in frames] == SHOWN
    assert sorted(p.name for p in project.iterdir() if "part" in p.name) == []


def test_no_sound_leaves_the_house_and_the_timeline_keeps_its_own(built, blender):
    edl, out = built.with_name("edl.json"), built.with_name("out.mp4")
    for source in (edl, built):
        render(source, out, preset="review", blender=blender, audio="none")
        with av.open(str(out)) as container:
            assert [stream.type for stream in container.streams] == ["video"]
    render(built, out, preset="review", blender=blender)
    with av.open(str(out)) as container:
        assert [stream.type for stream in container.streams] == ["video", "audio"]
    with pytest.raises(UsageError, match="a timeline has its own sound"):
        render(built, out, blender=blender, preset="review", audio="cam2")


@pytest.mark.parametrize("engine", ["blender", "direct"])
def test_a_camera_without_sound_gives_none_and_not_the_references(project, blender, engine):
    out = project / "out.mp4"
    render(project / "edl.json", out, preset="review", blender=blender, engine=engine, audio="cam3")
    with av.open(str(out)) as container:
        assert [stream.type for stream in container.streams] == ["video"]


@pytest.mark.parametrize("engine", ["blender", "direct"])
def test_a_size_that_halves_to_an_odd_number(project, blender, engine):
    edls.save(an_edl(size=(322, 182)), project / "edl.json")
    render(project / "edl.json", project / "out.mp4", preset="review", engine=engine, blender=blender)
    assert lumas(project / "out.mp4")[0].shape == (90, 160)


def test_both_engines_make_the_same_programme(project, blender):
    turned = ((0.98, -0.12, 14.0), (0.12, 0.98, -12.0), (5e-5, 2e-5, 1.0))
    poses = tuple(attrs.evolve(p, homographies={**p.homographies, "cam2": turned}) for p in an_edl().poses)
    keys = ((0, 0.0, 0.0), (25, 6.5, -3.25), (59, -4.0, 2.0))
    edls.save(an_edl(poses=poses, centering=keys), project / "edl.json")
    for engine in ("blender", "direct"):
        render(project / "edl.json", project / f"{engine}.mp4", engine=engine, blender=blender)
    a, b = lumas(project / "blender.mp4"), lumas(project / "direct.mp4")
    assert len(a) == len(b) == FRAMES
    # Blender's way has two more lossy steps than the direct one: the conformed chunk (CRF 14, 44 dB and more) and
    # 8-bit RGB with chroma sampled up and down again (48 dB in luma). Together with each engine's own delivery at
    # CRF 17 (42 dB and more) their noise adds up to about 39 dB on busy pictures; a frame off or a pixel's shift
    # comes out below 32 dB.
    assert min(psnr(x, y) for x, y in zip(a, b, strict=True)) >= 38
    assert [number_of(x) for x in a[:20]] == [number_of(x) for x in b[:20]] == list(range(20))
    assert max(psnr(x, y) for x, y in zip(a[1:], b, strict=False)) < 38  # the bound would notice one frame


def title(project, blend, blender):
    """What an editor lays on top: a white bar on the first channel above Conformed, and a switched source."""
    code = """
        new = dict(length=10) if bpy.app.version >= (5, 0) else dict(frame_end=5 + 10 + 1)
        bar = strips.new_effect(name="title", type="COLOR", channel=8, frame_start=5 + 1, **new)
        bar.color = (1, 1, 1)
        bar.blend_type = "ALPHA_OVER"
        bar.transform.scale_y = 0.06
        bar.transform.offset_y = 78
        at(5, 20).multicam_source = 3
        scene.render.filepath = "//finale.mp4"
    """
    in_blender(blender, blend, code)


def test_a_timeline_is_pulled_conformed_and_rendered_with_what_lies_above(built, blender):
    title(built.parent, built, blender)
    out = built.parent / "out.mp4"
    render(built, out, preset="h264", blender=blender)
    edl = edls.load(built.parent / "edl.json")
    assert edl.overrides == (*an_edl().overrides, Override(R(20, 40), camera="cam3"))
    frames = lumas(out)
    assert [number_of(luma) for luma in frames] == list(range(FRAMES))
    assert [ground_of(luma) for luma in frames] == ["cam3" if 20 <= i < 40 else c for i, c in enumerate(SHOWN)]
    assert [i for i, luma in enumerate(frames) if luma[11:13, 100:220].mean() > 225] == list(range(5, 15))
    found = in_blender(
        blender,
        built,
        """
        out = [sorted([s.channel, s.name, *span(s)] for s in strips if s.channel > 6), scene.render.filepath,
               sorted({s.filepath for s in strips if s.type == "MOVIE" and s.channel == 7}),
               [s.sound.filepath for s in strips if s.type == "SOUND"]]
        """,
        save=False,
    )
    assert found[0] == [[7, "conformed", 0, FRAMES], [8, "title", 5, 15]]
    assert found[1] == "//finale.mp4"  # the editor's own output settings stay
    assert found[2][0].startswith("//edl.conformed/0000000-0000060-")
    assert found[3][0].startswith("//edl.conformed/sound-")

    # plain `blender -b edit.blend -a` now gives the same video
    plain = built.parent / "finale.mp4"
    if blender.kind == "binary":
        command = [*blender.command, "-b", str(built), "-a"]
    else:
        code = (
            "import bpy, os, sys; bpy.ops.wm.open_mainfile(filepath=sys.argv[1]);"
            "bpy.ops.render.render(animation=True); sys.stdout.flush(); os._exit(0)"
        )
        command = [*blender.command, "-c", code, str(built)]
    subprocess.run(command, check=True, capture_output=True, timeout=120)
    again = lumas(plain)
    assert len(again) == FRAMES
    assert all((x == y).all() for x, y in zip(frames, again, strict=True))

    # and once more: nothing new is decided, nothing is conformed twice, nothing piles up
    before = sorted(p.stat().st_mtime_ns for p in (built.parent / "edl.conformed").iterdir())
    render(built, out, preset="h264", blender=blender)
    assert sorted(p.stat().st_mtime_ns for p in (built.parent / "edl.conformed").iterdir()) == before
    assert all((x == y).all() for x, y in zip(frames, lumas(out), strict=True))
    count = "out = [len([s for s in strips if s.get('mcsl') == r]) for r in ('programme', 'conformed', 'sound')]"
    assert in_blender(blender, built, count, save=False) == [5, 1, 1]


def test_what_the_editor_laid_on_our_channels_moves_up(built, blender):
    code = """
        new = dict(length=10) if bpy.app.version >= (5, 0) else dict(frame_end=5 + 10 + 1)
        strips.new_effect(name="low", type="COLOR", channel=7, frame_start=5 + 1, **new)
        strips.new_effect(name="high", type="COLOR", channel=8, frame_start=5 + 1, **new)
    """
    in_blender(blender, built, code)
    render(built, built.parent / "out.mp4", preset="review", blender=blender)
    found = in_blender(blender, built, "out = {s.name: s.channel for s in strips if s.type == 'COLOR'}", save=False)
    assert found == {"low": 8, "high": 9}


def test_the_direct_engine_takes_a_timeline_too(built, blender):
    in_blender(blender, built, "at(5, 20).multicam_source = 3")
    out = built.parent / "out.mp4"
    render(built, out, preset="review", engine="direct", blender=blender)
    assert [ground_of(luma) for luma in lumas(out)][20:40] == ["cam3"] * 20


def test_a_timeline_built_after_conforming_has_the_exact_pictures_in_place(project, blender):
    from mcsl_core.blender.timeline import build_timeline

    render(project / "edl.json", project / "out.mp4", preset="review", blender=blender)
    assert build_timeline(project / "edl.json", project / "edit.blend", blender=blender).conformed == 1
    code = "out = {s['mcsl']: [s.channel, *span(s)] for s in strips if s.get('mcsl') in ('conformed', 'sound')}"
    found = in_blender(blender, project / "edit.blend", code, save=False)
    assert found == {"sound": [1, 0, FRAMES], "conformed": [7, 0, FRAMES]}


@pytest.mark.parametrize(
    ("source", "out", "fields", "kind", "message"),
    [
        ("edl.json", "out.mov", {}, UsageError, r"writes \.mp4 files"),
        ("edl.json", "out.mp4", {"preset": "vhs"}, UsageError, "no preset 'vhs'"),
        ("edl.json", "out.mp4", {"engine": "magic"}, UsageError, "no engine 'magic'"),
        ("cam2.mp4", "out.mp4", {}, UsageError, "neither an EDL"),
        ("none.json", "out.mp4", {}, InputError, "is missing"),
    ],
)
def test_a_wrong_call_is_refused_before_any_work(project, blender, source, out, fields, kind, message):
    with pytest.raises(kind, match=message):
        render(project / source, project / out, blender=blender, **fields)
    assert not (project / "edl.conformed").exists()


@pytest.mark.parametrize(("name", "from_timeline"), [("archive", False), ("review", True)])
def test_what_is_removed_is_not_rendered(project, blender, name, from_timeline):
    """The same pictures as without, less those that are removed; silence at the seams, and the sound in time."""
    suffix = presets.load_preset(name).container
    edl, whole, out = project / "edl.json", project / f"whole.{suffix}", project / f"out.{suffix}"
    render(edl, whole, preset=name, blender=blender)
    was = edls.load(edl)
    edls.save(attrs.evolve(was, removed=(R(7, 22), R(50, FRAMES))), edl)
    source = edl
    if from_timeline:
        source = project / "edit.blend"
        build_timeline(edl, source, blender=blender)
    render(source, out, preset=name, blender=blender)
    left = [n for n in range(FRAMES) if not (7 <= n < 22 or n >= 50)]
    made, all_of_it = lumas(out), lumas(whole)
    assert len(made) == len(left)
    worst = min(psnr(picture, all_of_it[n]) for picture, n in zip(made, left, strict=True))
    assert worst == float("inf") if name == "archive" else worst > 45
    heard, before = (heard_in(path) for path in (out, whole))
    a_frame = 48000 / RATE
    seam, there, fade = (round(frame * a_frame) for frame in (7, 22, 2))
    rising = (np.arange(fade) + 0.5) / fade
    expected = np.concatenate([before[:seam], before[there : there + 28 * 1601]])
    expected[seam - fade : seam] *= rising[::-1]
    expected[seam : seam + fade] *= rising
    off = np.abs(heard[: len(expected)] - expected)
    assert off.max() < 0.002 if name == "archive" else np.sqrt(np.mean(off**2)) < 0.01  # review's AAC is lossy


def test_a_render_that_fails_leaves_the_old_video(project, blender):
    out = project / "out.mp4"
    out.write_bytes(b"the old one")
    (project / "cam2.mp4").unlink()
    with pytest.raises(InputError, match=r"cam2\.mp4"):
        render(project / "edl.json", out, preset="review", blender=blender, force=True)
    assert out.read_bytes() == b"the old one"
    assert not list(project.glob(".mcsl*"))


def test_a_render_that_is_stopped_leaves_the_old_video_and_no_part(project, blender):
    class Impatient(Silent):
        def advance(self, done):
            if self.rendering:
                self.token.cancel()
            self.token.check()

        def stage(self, name, total=None, unit=""):
            self.rendering = name == "render"

    out = project / "out.mp4"
    out.write_bytes(b"the old one")
    with pytest.raises(Cancelled):
        render(project / "edl.json", out, preset="review", blender=blender, force=True, progress=Impatient())
    assert out.read_bytes() == b"the old one"
    assert not list(project.glob(".mcsl*"))
