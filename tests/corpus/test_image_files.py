"""Image and video files, drawn with a seed: the sensor's pixels are read, in natural order, or the cause is named."""

from pathlib import Path

import av
import cv2
import numpy as np
import pytest
from PIL import Image

from errors import refused
from palpate.camera import list_images, open_source, read_image
from palpate.core import PalpateError
from palpate.datasets import ColumnMapping, read_recording
from palpate.vision import prepare_detector

RANDOM = np.random.default_rng(2)
PLACES = np.array([(24.0 + 18 * x, 22.0 + 18 * y) for y in range(6) for x in range(8)]) + RANDOM.uniform(
    -1, 1, (48, 2)
)
DEPTHS = {"8": (np.uint8, 255), "10": (np.uint16, 1023), "12": (np.uint16, 4095), "16": (np.uint16, 65535)}


def drawn() -> np.ndarray:
    """(130, 180) dark dots on grey, 0 to 1, with noise."""
    y, x = np.mgrid[:130, :180]
    away = np.min(np.hypot(x[..., None] - PLACES[:, 0], y[..., None] - PLACES[:, 1]), axis=-1)
    image = 0.75 - 0.5 * np.clip(4.5 - away, 0, 1)
    return np.clip(image + np.random.default_rng(3).normal(0, 0.005, image.shape), 0, 1)


def found_all(path: Path) -> bool:
    image = read_image(path)
    dots = prepare_detector(image).find(image).positions_px
    gaps = np.linalg.norm(PLACES[:, None] - dots, axis=-1).min(axis=1)
    return len(dots) == len(PLACES) and bool(gaps.max() < 0.6)


@pytest.mark.parametrize("bits", DEPTHS)
@pytest.mark.parametrize("ending", ["png", "tif", "pgm"])
def test_dots_of_any_bit_depth_are_found(bits: str, ending: str, tmp_path: Path) -> None:
    kind, top = DEPTHS[bits]
    cv2.imwrite(str(tmp_path / f"a.{ending}"), np.rint(drawn() * top).astype(kind))
    assert found_all(tmp_path / f"a.{ending}")


@pytest.mark.parametrize("kind", ["float", "alpha", "grey as colour", "16 bit colour"])
def test_dots_of_any_layout_are_found(kind: str, tmp_path: Path) -> None:
    grey, path = drawn(), tmp_path / ("a.tif" if kind == "float" else "a.png")
    colour = np.repeat(np.rint(grey * 255).astype(np.uint8)[..., None], 4, axis=-1)
    colour[..., 3] = 200
    image = {
        "float": grey.astype(np.float32),
        "alpha": colour,
        "grey as colour": colour[..., :3],
        "16 bit colour": colour[..., :3].astype(np.uint16) * 256,
    }[kind]
    cv2.imwrite(str(path), image)
    assert found_all(path)


@pytest.mark.parametrize("quality", [90, 80, 70, 60])
@pytest.mark.parametrize("noise", [4, 8])
def test_dots_are_found_in_compressed_noise(noise: int, quality: int, tmp_path: Path) -> None:
    grey = drawn() * 255 + np.random.default_rng(7).normal(0, noise, (130, 180))
    cv2.imwrite(str(tmp_path / "a.jpg"), np.clip(grey, 0, 255).astype(np.uint8), [cv2.IMWRITE_JPEG_QUALITY, quality])
    assert found_all(tmp_path / "a.jpg")


@pytest.mark.parametrize("same", [True, False])
def test_a_stack_is_refused_and_a_preview_passed_over(same: bool, tmp_path: Path) -> None:
    image = Image.fromarray(np.rint(drawn() * 255).astype(np.uint8))
    image.save(tmp_path / "a.tif", save_all=True, append_images=[image if same else image.resize((45, 32))])
    if not same:
        assert found_all(tmp_path / "a.tif")
        return
    with refused("image-stack", "a.tif", "2"):
        read_image(tmp_path / "a.tif")
    content = bytearray((tmp_path / "a.tif").read_bytes())
    first = int.from_bytes(content[4:8], "little")
    end = first + 2 + 12 * int.from_bytes(content[first : first + 2], "little")
    second = int.from_bytes(content[end : end + 4], "little")
    content[second + 2 : second + 4] = b"\xff\x7f"  # the tag of the second page's width
    (tmp_path / "a.tif").write_bytes(content)
    with refused("image-unreadable", "a.tif"):
        read_image(tmp_path / "a.tif")


@pytest.mark.parametrize("orientation", range(2, 9))
def test_the_orientation_of_a_photograph_is_ignored(orientation: int, tmp_path: Path) -> None:
    path = tmp_path / "a.jpg"
    exif = Image.Exif()
    exif[0x0112] = orientation
    Image.fromarray(np.rint(drawn() * 255).astype(np.uint8)).save(path, exif=exif, quality=95)
    assert read_image(path).shape[:2] == (130, 180)
    assert found_all(path)


@pytest.mark.parametrize("first", [(0, 0), (0, 1), (1, 0), (1, 1)], ids=["RGGB", "GRBG", "GBRG", "BGGR"])
@pytest.mark.parametrize("bits", ["8", "12"])
def test_a_mosaic_is_developed(first: tuple[int, int], bits: str, tmp_path: Path) -> None:
    kind, top = DEPTHS[bits]
    grey = drawn()
    mosaic = grey.copy()
    mosaic[first[0] :: 2, first[1] :: 2] *= 0.5
    mosaic[1 - first[0] :: 2, 1 - first[1] :: 2] *= 0.7
    cv2.imwrite(str(tmp_path / "a.png"), np.rint(mosaic * top).astype(kind))
    assert np.abs(read_image(tmp_path / "a.png") / top - grey).mean() < 0.02
    assert found_all(tmp_path / "a.png")


def test_a_grey_image_is_no_mosaic(tmp_path: Path) -> None:
    image = np.rint(drawn() * 255).astype(np.uint8)
    for name, one in {"dots": image, "noise": RANDOM.integers(0, 255, (64, 64), np.uint8)}.items():
        cv2.imwrite(str(tmp_path / f"{name}.png"), one)
        assert np.array_equal(read_image(tmp_path / f"{name}.png"), one)


def test_frames_come_in_natural_order(tmp_path: Path) -> None:
    for number in (10, 9, 2, 1, 100):
        cv2.imwrite(str(tmp_path / f"frame_{number}.png"), np.full((16, 16), number, np.uint8))
    assert [path.stem for path in list_images(tmp_path)] == [f"frame_{number}" for number in (1, 2, 9, 10, 100)]
    with open_source(str(tmp_path)) as source:
        assert [int(image.max()) for image in source.images() if not isinstance(image, PalpateError)] == [
            1,
            2,
            9,
            10,
            100,
        ]


@pytest.mark.parametrize(
    ("content", "code"),
    [
        (b"", "image-format-unknown"),
        (b"hello", "image-format-unknown"),
        (b"\x89PNG\r\n\x1a\n" + b"0" * 40, ("image-unreadable", "image-format-unknown")),
        (b"\xff\xd8\xff\xe0" + b"1" * 20, ("image-unreadable", "image-format-unknown")),
    ],
)
def test_no_image_is_refused(content: bytes, code: str, tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(content)
    with refused(code, "a.png"):
        read_image(tmp_path / "a.png")


def write_video(path: Path, codec: str, stamps: list[int], **options: str) -> None:
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=10, options=options)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        for number, stamp in enumerate(stamps):
            frame = av.VideoFrame.from_ndarray(
                np.full((48, 64, 3), (20 * number + 20) % 256, np.uint8), format="bgr24"
            )
            frame.pts = stamp
            container.mux(stream.encode(frame))
        container.mux(stream.encode())


VIDEOS = {
    "h264.mp4": ("libx264", range(8), {}),
    "h264_with_b_frames.mp4": ("libx264", range(8), {"bf": "3"}),
    "variable_rate.mp4": ("libx264", [0, 1, 2, 7, 8, 9, 20, 21], {}),
    "variable_rate.mkv": ("libx264", [0, 1, 2, 7, 8, 9, 20, 21], {}),
    "av1.mp4": ("libsvtav1", range(8), {}),
}


@pytest.mark.parametrize("name", VIDEOS)
def test_all_images_of_a_video_are_read(name: str, tmp_path: Path) -> None:
    codec, stamps, options = VIDEOS[name]
    write_video(tmp_path / name, codec, list(stamps), **options)
    with open_source(str(tmp_path / name)) as source:
        images = list(source.images())
    assert [isinstance(image, PalpateError) for image in images] == [False] * 8, images[-1]
    assert [round(float(image.mean()) / 20) - 1 for image in images] == list(range(8))  # type: ignore[union-attr]


def test_av1_without_its_decoder_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_video(tmp_path / "a.mp4", "libsvtav1", list(range(4)))
    monkeypatch.setitem(__import__("sys").modules, "av", None)
    with open_source(str(tmp_path / "a.mp4")) as source:
        (error,) = source.images()
    assert isinstance(error, PalpateError)
    assert error.code == "video-av1"
    assert "ffmpeg" in error.remedy


def test_a_video_that_is_cut_off_is_still_reported(tmp_path: Path) -> None:
    write_video(tmp_path / "a.mp4", "libx264", list(range(12)), movflags="faststart")
    write_video(tmp_path / "a.avi", "mpeg4", list(range(12)))
    content = (tmp_path / "a.avi").read_bytes()
    (tmp_path / "a.avi").write_bytes(content[: len(content) // 2])
    try:
        with open_source(str(tmp_path / "a.avi")) as source:
            last = list(source.images())[-1]
    except PalpateError as error:
        last = error
    assert isinstance(last, PalpateError)


@pytest.mark.parametrize("name", ["a.mkv", "a.webm"])
@pytest.mark.parametrize("share", [0.6, 0.95])
def test_a_matroska_video_without_its_last_images_is_reported(name: str, share: float, tmp_path: Path) -> None:
    path = tmp_path / name
    write_video(path, "libx264" if name.endswith("mkv") else "libvpx-vp9", list(range(200)))
    with open_source(str(path)) as source:
        assert not any(isinstance(image, PalpateError) for image in source.images()), "the whole video"
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    with open_source(str(path)) as source:
        last = list(source.images())[-1]
    assert isinstance(last, PalpateError)
    assert last.code == "video-cut-off"


def test_rows_find_the_video_of_their_press(tmp_path: Path) -> None:
    rows = ["video,frame,press,rx_deg,depth_mm"]
    for press in range(8):
        write_video(tmp_path / f"press_{press}.avi", "mpeg4", list(range(3)))
        rows += [
            f"press_{press}.avi,{k},{press},{RANDOM.uniform(-9, 9):.3f},{1 + k + 0.1 * press:.2f}" for k in range(3)
        ]
    (tmp_path / "poses.csv").write_text("\n".join(rows) + "\n")
    recording = read_recording(tmp_path, ColumnMapping(image="frame"))
    assert len(recording) == 24
    images = list(recording.images.read([0, 1, 4]))
    assert [round(float(image.mean()) / 20) - 1 for image in images] == [0, 1, 1]  # type: ignore[union-attr]


GREYS = [round(20 + 9.5 * k) for k in range(24)]


def write_pressed(folder: Path, stamps: list[int], head: str, cells: list[str]) -> Path:
    """Video of 24 images at stamps of 0.1 s, and a table with these first cells and depths that name the image."""
    with av.open(str(folder / "gel.mkv"), "w") as container:
        stream = container.add_stream("libx264", rate=10, options={"crf": "8"})
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        for grey, stamp in zip(GREYS, stamps, strict=True):
            frame = av.VideoFrame.from_ndarray(np.full((48, 64, 3), grey, np.uint8), format="bgr24")
            frame.pts = stamp
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    rows = [f"{cell},{k // 3},{k % 7 - 3:.1f},{1.5 * k}" for k, cell in enumerate(cells) if cell]
    (folder / "poses.csv").write_text("\n".join([f"{head},press,rx_deg,depth_mm", *rows]) + "\n")
    return folder / "poses.csv"


STAMPS = np.cumsum([0, *np.random.default_rng(4).integers(1, 9, 23)]).tolist()
ROWS = {
    "times": ("time_s", [f"{stamp / 10:.3f}" for stamp in STAMPS], STAMPS),
    "times in ms": ("t [ms]", [f"{stamp * 100:.0f}" for stamp in STAMPS], STAMPS),
    "times without some rows": ("time_s", [f"{s / 10:.3f}" if k % 7 else "" for k, s in enumerate(STAMPS)], STAMPS),
    "times of one clock": ("time_s", [f"{s / 10 + 0.02:.3f}" for s in STAMPS], STAMPS),
    "times of a clock": ("time", [f"00:{s // 600:02d}:{s / 10 % 60:06.3f}" for s in STAMPS], STAMPS),
    "order": ("label", ["a"] * 24, list(range(24))),
    "counter from 0": ("frame_index", [str(k) for k in range(24)], STAMPS),
    "counter from 1": ("Frame", [str(k + 1) for k in range(24)], STAMPS),
    "counter from 1 without the last": ("frame", [str(k + 1) if k < 23 else "" for k in range(24)], None),
}


@pytest.mark.parametrize("kind", ROWS)
def test_rows_find_their_images_in_a_video(kind: str, tmp_path: Path) -> None:
    head, cells, stamps = ROWS[kind]
    found = read_recording(write_pressed(tmp_path, stamps or STAMPS, head, cells))
    numbers = [round(one / 1.5) for one in next(one for one in found.poses if one.axis == "depth").values]
    assert numbers == [k for k, cell in enumerate(cells) if cell]
    images = [float(np.mean(image)) for image in found.images.read(range(len(found)))]  # type: ignore[arg-type]
    shift = 0 if stamps else 1  # without the last number nothing shows that the first is 1
    assert images == pytest.approx([GREYS[number + shift] for number in numbers], abs=4.5)


@pytest.mark.parametrize(
    ("head", "cells", "code", "says"),
    [
        ("timestamp", [f"{1.7e9 + k / 10:.1f}" for k in range(24)], "times-no-overlap", "1700000002.300"),
        ("label", ["a"] * 22 + ["", ""], "image-column-missing", "22 rows"),
    ],
)
def test_rows_without_images_in_a_video_are_refused(
    head: str, cells: list[str], code: str, says: str, tmp_path: Path
) -> None:
    path = write_pressed(tmp_path, list(range(24)), head, cells)
    with refused(code, "gel.mkv", says):
        read_recording(path)


def test_of_rows_at_a_higher_rate_the_nearest_to_each_image_is_used(tmp_path: Path) -> None:
    path = write_pressed(tmp_path, list(range(24)), "time_s", [""] * 24)
    rows = [f"{k / 100:.2f},{k // 20},{k % 7 - 3},{k / 10 + 0.1:.2f}" for k in range(-5, 236)]
    path.write_text("\n".join(["time_s,press,rx_deg,depth_mm", *rows]) + "\n")
    found = read_recording(path)
    depth = next(one for one in found.poses if one.axis == "depth").values
    assert depth == pytest.approx(np.arange(24) + 0.1)
    assert any("217 of 241 rows" in note for note in found.notes)
