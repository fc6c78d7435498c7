"""What an analysis decided, for programs and for people."""

from __future__ import annotations

from mcsl_core import edl
from mcsl_core.edl.field import HAND, MIDDLE
from mcsl_core.progress import counted
from mcsl_core.timing import format_time, merge_equal

_MOST_GAPS = 5  # of a camera that are told one by one


def summary(made: edl.Edl) -> dict[str, object]:
    """What was decided, for programs."""
    settings = made.made_by.settings if made.made_by else {}
    return {
        "frames": made.frames,
        "seconds": round(float(made.frames / made.rate), 3),
        "cameras": [c.name for c in made.cameras],
        "movements": [[m.range.start, m.range.stop] for m in made.movements],
        "shots": len(made.shots),
        "overrides": len(made.overrides),
        "weak": [{"pose": i, "camera": w.camera, "reason": w.reason} for i, p in enumerate(made.poses) for w in p.weak],
        "gaps": {c.name: [[g.start, g.stop] for g in c.gaps] for c in made.cameras if c.gaps},
        "residual_px": [dict(p.residual_px) for p in made.poses],
        "fields": [{"range": [f.range.start, f.range.stop], "by": f.by} for f in made.fields],
        **({"gaze": settings["gaze"]} if "gaze" in settings else {}),
    }


def describe(made: edl.Edl) -> str:
    """What was decided, in a few lines for people."""
    seconds = made.frames / made.rate
    lines = [
        f"{counted(len(made.cameras), 'cameras')}, {format_time(seconds)} at {float(made.rate):.6g} frames/s, "
        f"{counted(len(made.shots), 'shots')}, {counted(len(made.overrides), 'overrides')}"
    ]
    for camera in made.cameras:
        if camera.gaps:
            spans = [" to ".join(format_time(f / made.rate) for f in (g.start, g.stop)) for g in camera.gaps]
            more = f" and {len(spans) - _MOST_GAPS} more" if len(spans) > _MOST_GAPS else ""
            lines.append(f"  no picture: {camera.name} from {', '.join(spans[:_MOST_GAPS])}{more}")
    for movement in made.movements:
        start, stop = (format_time(f / made.rate) for f in (movement.range.start, movement.range.stop))
        lines.append(f"  the lamp moves from {start} to {stop} (confidence {movement.confidence:.0%})")
    for pose in made.poses:
        fits = ", ".join(f"{n} {v:.1f}" for n, v in pose.residual_px.items())
        at = format_time(pose.range.start / made.rate)
        lines.append(f"  pose from {at}, perspective {pose.perspective}: residual px {fits or 'none'}")
        lines += [f"    weak: {w.camera}: {w.reason}" for w in pose.weak]
    lines += [f"  {line}" for line in _fields(made)]
    for file in made.made_by.settings.get("gaze", ()) if made.made_by else ():
        lines.append(f"  gaze of {file['file']}: {file['used']} of {file['samples']} looks used")
    return "\n".join(lines)


def _fields(made: edl.Edl) -> list[str]:
    """Where no field was found, or one was drawn; that it was found needs no line."""
    words = {
        MIDDLE: "nothing shows where the surgical field lies, the middle is taken (to draw it: mcsl field)",
        HAND: "the surgical field is the one drawn by hand",
    }
    lines = []
    for piece, by in merge_equal([(stretch.range, stretch.by) for stretch in made.fields]):
        if by in words:
            start, stop = (format_time(frame / made.rate) for frame in (piece.start, piece.stop))
            lines.append(f"from {start} to {stop}: {words[by]}")
    return lines
