"""Files of gaze as people and eye trackers write them: understood, or refused by line; every look is accounted for."""

from __future__ import annotations

from pathlib import Path

import pytest

from mcsl_core.centering.gaze import Gaze, fixations
from mcsl_core.centering.gaze_files import GazeFile, Shown, read_gaze
from mcsl_core.errors import DocumentError, InputError

SHOWN = Shown(rate=25.0, frames=300, size=(640, 360), cameras={"cam1": (1280, 720)})
FAULTS = Path(__file__).parents[3].parent / "shared" / "data" / "faults" / "gaze"
TIMES = [n / 60 for n in range(720)]  # twelve seconds at 60 samples a second, as the programme lasts
PLACE = (200.0, 150.0)


def write(path: Path, text: str | bytes) -> Path:
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def table(head: str, row: str, **scale: float) -> str:
    """A line a sample: {t} its seconds times the scale "t", {x} and {y} the place times theirs."""
    x, y = PLACE[0] * scale.get("x", 1), PLACE[1] * scale.get("y", 1)
    lines = [row.format(t=t * scale.get("t", 1), x=x, y=y, n=n) for n, t in enumerate(TIMES)]
    return "\n".join([head, *lines]) + "\n"


def middle(file: GazeFile) -> tuple[float, float]:
    ((_, at),) = fixations(file.looks, lambda *_: None, frames=SHOWN.frames, size=SHOWN.size, rate=SHOWN.rate)
    return at


PLAIN = table("time,x,y", "{t:.4f},{x},{y}")
PUPIL = "section id,recording id,timestamp [ns],gaze x [px],gaze y [px],worn\n"
UNDERSTOOD = {
    "plain": PLAIN,
    "frames": table("frame,x,y", "{t},{x},{y}", t=25),
    "semicolons and decimal commas": PLAIN.replace(",", ";").replace(".", ","),
    "tabs": PLAIN.replace(",", "\t"),
    "Excel's first line": "sep=;\n" + PLAIN.replace(",", ";"),
    "a mark of byte order": b"\xef\xbb\xbf" + PLAIN.encode(),
    "UTF-16": PLAIN.encode("utf-16"),
    "UTF-16, the other order": b"\xfe\xff" + PLAIN.encode("utf-16-be"),
    "lines of Windows": PLAIN.replace("\n", "\r\n"),
    "lines of an old Macintosh": PLAIN.replace("\n", "\r"),
    "names in capitals with blanks": PLAIN.replace("time,x,y", " Time , X , Y ", 1),
    "hours, minutes and seconds": table("time,x,y", "00:00:{t:07.4f},{x},{y}"),
    "minutes and seconds, as spreadsheets show them": table("time,x,y", "0:{t:06.3f},{x},{y}"),
    "the same with decimal commas": table("time;x;y", "00:00:{t:06.3f};{x};{y}").replace(".", ","),
    "milliseconds": table("time_ms,x,y", "{t:.1f},{x},{y}", t=1e3),
    "milliseconds in brackets": table("time [ms],x [px],y [px]", "{t:.1f},{x},{y}", t=1e3),
    "shares of the picture": table("time,x,y", "{t},{x},{y}", x=1 / 640, y=1 / 360),
    "a camera's pixels": table("time,x,y,camera", "{t},{x},{y},", x=1),
    "Tobii in us without a unit": table("Recording timestamp\tGaze point X\tGaze point Y", "{t:.0f}\t{x}\t{y}", t=1e6),
    "Tobii in ms without a unit": table("Recording timestamp\tGaze point X\tGaze point Y", "{t:.0f}\t{x}\t{y}", t=1e3),
    "Tobii, units and both kinds of place": table(
        "Recording timestamp [μs]\tGaze point X [DACS px]\tGaze point Y [DACS px]\tGaze point X [MCS px]"
        "\tGaze point Y [MCS px]",
        "{t:.0f}\t1800\t900\t{x:.0f}\t{y:.0f}",
        t=1e6,
    ),
    "Tobii Studio": table("RecordingTimestamp\tGazePointX (MCSpx)\tGazePointY (MCSpx)", "{t:.0f}\t{x}\t{y}", t=1e3),
    "Pupil with a programme's time": table(
        "gaze_timestamp,confidence,norm_pos_x,norm_pos_y", "{t},0.9,{x},0.583333333", x=1 / 640
    ),
    "Pupil's surface": table("world_timestamp,x_norm,y_norm,on_surf", "{t},{x},0.583333333,True", x=1 / 640),
}


@pytest.mark.parametrize("name", UNDERSTOOD)
def test_what_trackers_and_spreadsheets_write_is_understood(tmp_path: Path, name: str) -> None:
    file = read_gaze(write(tmp_path / "g", UNDERSTOOD[name]), SHOWN)
    assert middle(file) == pytest.approx(PLACE, abs=1)
    assert (len(file.looks), file.samples) == (720, 720)
    assert str(file).startswith("720 of 720 looks are used")


LOST = {"-1,-1": 0, "nan,nan": 0, ",": 0, "NA,NA": 0, "0,0": 0, "-9999,-9999": 0, "900,100": 1, "100,-40": 1}


@pytest.mark.parametrize(("place", "outside"), LOST.items())
def test_lost_eyes_and_looks_past_the_picture_are_left_out_and_counted(
    tmp_path: Path, place: str, outside: int
) -> None:
    lines = PLAIN.splitlines()
    for at in range(3, len(lines), 3):
        lines[at] = f"{lines[at].split(',')[0]},{place}"
    file = read_gaze(write(tmp_path / "g.csv", "\n".join(lines)), SHOWN)
    assert middle(file) == pytest.approx(PLACE, abs=1e-9)
    assert (len(file.looks), file.blind + file.outside, file.samples) == (480, 240, 720)
    assert f"480 of 720 looks are used (240 {'past the picture' if outside else 'without eyes'})" in str(file)


def test_unsure_eyes_of_pupil_are_left_out(tmp_path: Path) -> None:
    text = table("gaze_timestamp,confidence,norm_pos_x,norm_pos_y", "{t},0.9,0.5,0.5").replace(",0.9,", ",0.3,", 100)
    assert read_gaze(write(tmp_path / "g.csv", text), SHOWN).blind == 100


def test_a_cameras_shares_are_of_its_own_picture(tmp_path: Path) -> None:
    (look,) = read_gaze(write(tmp_path / "g.csv", "frame,x,y,camera\n3,0.5,0.25,cam1\n"), SHOWN).looks
    assert look == Gaze(3, "g.csv", 639.5, 179.5, "cam1")


def test_fractions_of_three_digits_are_no_thousands(tmp_path: Path) -> None:
    text = "time,x,y\n0.001,100.125,80.5\n0.002,1.125,300\n"
    assert [look.x for look in read_gaze(write(tmp_path / "g.csv", text), SHOWN).looks] == [100.125, 1.125]


def test_observers_and_blinks_and_few_lines(tmp_path: Path) -> None:
    path = write(tmp_path / "視線.csv", "frame,observer,x,y,camera\n3,Kim,1,2,cam1\n\n4,Kim,,\n5,,50,60,\n")
    file = read_gaze(path, SHOWN)
    assert file.looks == (Gaze(3, "Kim", 1, 2, "cam1"), Gaze(5, "視線.csv", 50, 60))
    assert (file.samples, file.blind) == (3, 1)


REFUSED = {
    "": "is empty",
    "a,b\n1,2\n": "line 1: has the columns 'a', 'b', expected frame or time, x and y, or Tobii's or Pupil's",
    "time,x,x,y\n1,2,3,4\n": "names the column 'x' twice",
    "frame,x,y\n1,20,30\nsoon,20,30\n": "line 3: 'soon' is no number",
    "frame,x,y\n1,20,30\n,20,30\n": "line 3: '' is no number",
    "frame,x,y\n1,1e999,30\n": "line 2: '1e999' is too large a number",
    "frame,x,y\n1_0,2,3\n": "line 2: '1_0' is no number",
    "frame,x,y,camera\n1,2,3,cam9\n": "line 2: 'cam9' is not a camera, expected one of cam1",
    'time,x,y,observer\n0.1,500,300,"Kim\n0.2,1,2,Sato\n': "line 2: a quotation mark is opened and not closed",
    'time,x,y,observer\n0.1,5,30,"Kim\n0.2,1,2,"Sato"\n': "line 2: a quotation mark is opened and not closed",
    "time,x,y\n0,1,512,3\n": "line 2: has 4 cells, the first line names 3 columns",
    "time,x,y\n0.1,,\n0.2,-1,-1\n": "none of its 2 lines has eyes",
    "time,x,y,note\n0,1,2," + "a" * 140_000 + "\n": "line 2: a cell has more than 131,072 characters",
    table("time,x,y", "{t:.1f},{x},{y}", t=1e3): "line 3: 719 of 720 looks lie outside of the programme",
    table("timestamp,x,y", "{t},{x},{y}").replace("\n", "\n17356896", 720): "it lasts 12 s, they go from 1.73569e+",
    PUPIL + "s,r,1735689600000000000,200,150,1\n": "line 2: 1 of 1 looks lie outside of the programme",
    table("time,x,y", "{t},{x},{y}", x=6, y=6): "line 2: 720 of 720 looks lie past the picture of 640x360 pixels",
    table("time,gaze point x [DACS px],gaze point y [DACS px]", "{t},{x},{y}"): "no place in the picture",
    table("time,x,y", "00:00:{t:05.2f}:00,{x},{y}"): "line 2: '00:00:00.00:00' is no number, and no time of hours",
    table("frame,x,y", "0:0:{t:.3f},{x},{y}"): "line 2: '0:0:0.000' is no number",
    'time,x,y\n0.1,"1,100",980\n0.2,980,"1,050"\n': "line 2: '1,100' may be 1100 or 1.1",
    "time;x;y\n0,1;150;1.010\n0,2;160;20\n": "line 2: '1.010' may be 1010 or 1.01",
    "frame;x;y\n999;150;1\n1.001;160;20\n": "line 3: '1.001' may be 1001 or 1.001",
    "time,x,y\n": "holds no looks",
    table("time [h],x,y", "{t},{x},{y}"): "unit of time that is not known",
    table("Recording timestamp\tGaze point X\tGaze point Y", "{t}\t{x}\t{y}"): "names no unit",
    table("gaze_timestamp,norm_pos_x,norm_pos_y", "{t},{x},{y}"): "should be a share of the picture",
}


@pytest.mark.parametrize("text", REFUSED)
def test_what_cannot_be_understood_is_refused_by_its_line(tmp_path: Path, text: str) -> None:
    path = write(tmp_path / "gaze.csv", text)
    with pytest.raises(DocumentError) as refused:
        read_gaze(path, SHOWN)
    assert REFUSED[text] in str(refused.value)
    assert str(path) in refused.value.where


def test_bytes_that_are_no_text_are_refused_by_their_line(tmp_path: Path) -> None:
    with pytest.raises(DocumentError, match=r"line 3: is not UTF-8 text"):
        read_gaze(write(tmp_path / "g.csv", b"time,x,y\n1,2,3\n2,\xe9,3\n"), SHOWN)


def test_a_missing_file_is_an_input_error(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="does not exist"):
        read_gaze(tmp_path / "none.csv", SHOWN)


@pytest.mark.parametrize(
    ("name", "used"), [("ok", 720), ("norm", 720), ("offscreen", 240), ("nan", 705), ("tobii", 720)]
)
def test_the_faulty_files_that_were_reported_are_read(name: str, used: int) -> None:
    if not FAULTS.is_dir():
        pytest.skip("the material is not here")
    path = next(FAULTS.glob(f"g_{name}.*"))
    file = read_gaze(path, SHOWN)
    assert (len(file.looks), file.samples) == (used, 720)
    assert middle(file) == pytest.approx(middle(read_gaze(FAULTS / "g_ok.csv", SHOWN)), abs=1)


@pytest.mark.parametrize(("name", "said"), [("pupil", "outside of the programme"), ("quote_small", "line 2")])
def test_the_faulty_files_that_were_reported_are_refused(name: str, said: str) -> None:
    if not FAULTS.is_dir():
        pytest.skip("the material is not here")
    with pytest.raises(DocumentError, match=said):
        read_gaze(FAULTS / f"g_{name}.csv", SHOWN)
