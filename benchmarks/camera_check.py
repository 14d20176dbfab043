"""Faults of cameras named by `palpate.rig.check_camera`: image sets with one fault each, and good ones.

    python benchmarks/camera_check.py [SETS_PER_KIND] [GOOD_SETS] [OUT.csv] [SEED]

Markers of five designs are rendered without defects. All defects are applied here, in floating point: blur, motion
kernels, light, shot and read noise, colour, geometry, time stamps. A fault is drawn over the range in `FAULTS`; the
first number is the weakest one. Good sets draw every property over the range in `good`. Half of the sets have
images of a press by a flat wall, which changes the light near the contact by up to 20 %. Half are in colour, a third
have bright markers, and a third a bright rim and clutter. If no marker is found, the check is repeated with known
polarity and diameter, as its remedy recommends (`hinted`). One row a kind: the sets, those whose fault is named (good
sets: without a finding), those without another finding, and all other findings with their numbers.
"""

import csv
import sys
from collections import Counter
from dataclasses import dataclass, field
from functools import cache, lru_cache
from pathlib import Path

import cv2
import numpy as np

from palpate.camera import Camera, CameraSpec, RenderSpec, build_camera, flat_marker_outlines, render
from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.rig import CameraCheck, check_camera
from palpate.vision import DetectSpec

DESIGNS = (
    (20.0, 37, 1.5, 1.0),
    (20.0, 169, 1.2, 1.0),
    (20.0, 61, 1.6, 1.85),
    (10.0, 91, 1.3, 1.4),
    (30.0, 61, 1.4, 1.0),
)
"""Height (mm), number and diameter (mm) of the markers, and size of the image over 346 x 260 px."""
REST, PRESS, FPS = 24, 8, 30.0
FAULTS = {
    "blank": ("grey level of a covered lens", 3.0, 40.0),
    "frozen": ("share of repeated images", 0.65, 1.0),
    "saturated": ("share of the field at the maximum grey value", 0.05, 0.6),
    "dark": ("grey level of the skin over 255", 0.2, 0.08),
    "at_border": ("markers cut by the border", 1.0, 10.0),
    "contrast": ("contrast over the light", 0.16, 0.08),
    "evenness": ("light at the darkest markers over that at the brightest", 0.38, 0.12),
    "focus": ("blur over the radius of markers", 0.65, 1.1),
    "noise": ("noise of a centre by the Cramer-Rao bound, px", 0.07, 0.11),
    "motion_blur": ("motion in an exposure, px", 2.5, 6.0),
    "vibration": ("standard deviation of the shift, px", 0.2, 1.5),
    "drift": ("shift over the set, px", 0.3, 3.0),
    "magnification": ("rms motion by the change of scale, px", 0.2, 2.0),
    "sharpness": ("relative change of the blur", 0.4, 1.5),
    "brightness": ("relative change of the light", 0.06, 0.4),
    "auto_exposure": ("relative change of the light by a press", 0.2, 0.6),
    "white_balance": ("relative change of a colour", 0.06, 0.4),
    "dropped": ("share of missing images", 0.05, 0.3),
    "irregular": ("standard deviation of intervals over their mean", 0.35, 0.8),
}
"""Kind -> physical quantity of the fault, its weakest and its strongest value."""


@dataclass
class Draw:
    """Properties of one image set; `scale`, `shift_px`, `light`, `blur` have a value for each image at rest."""

    design: int
    seed: int
    colour: bool
    bright: bool
    press: bool
    rim: bool
    offset: tuple[float, float] = (0.0, 0.0)
    level: float = 180.0
    contrast: float = 0.65
    edge: float = 0.8
    noise: float = 1.5
    dimmest: float = 0.7
    motion: float = 0.0
    shift_px: np.ndarray = field(default_factory=lambda: np.zeros((REST, 2)))
    magnified_px: np.ndarray = field(default_factory=lambda: np.zeros(REST))
    light: np.ndarray = field(default_factory=lambda: np.ones(REST))
    press_light: float = 1.0
    blur: np.ndarray = field(default_factory=lambda: np.ones(REST))
    balance: np.ndarray = field(default_factory=lambda: np.ones(REST))
    covered: float = 0.0
    clipped: float = 0.0
    repeated: float = 0.0
    times: np.ndarray = field(default_factory=lambda: np.arange(REST) / FPS)


@cache
def scene(design: int, offset: tuple[float, float] = (0.0, 0.0)) -> tuple[Camera, np.ndarray]:
    """Camera, and outlines (m, k, 3) of the markers, mm."""
    height, count, diameter, zoom = DESIGNS[design]
    skin, plain = build_skin(DomeSpec(height=height, thickness=2.0)), CameraSpec()
    sizes = ("width_px", "height_px", "fx_px", "fy_px", "cx_px", "cy_px")
    scaled = {name: type(getattr(plain, name))(round(zoom * getattr(plain, name), 1)) for name in sizes}
    spec = plain.model_copy(update=scaled | {"offset_x": offset[0], "offset_y": offset[1]})
    points = place_markers(skin, MarkerSpec(count=count, diameter=diameter)).positions
    return build_camera(spec), flat_marker_outlines(points, skin.normal(points), diameter)


@lru_cache(maxsize=32)
def covers(design: int, offset: tuple[float, float], depth: float, rim: bool) -> tuple[np.ndarray, np.ndarray]:
    """Share (h, w) of each pixel that markers cover under a flat wall, and grey levels of clutter outside (or -1)."""
    camera, edges = scene(design, offset)
    wall = edges[..., 2].max() - depth
    pushed = np.maximum(edges[..., 2] - wall, 0.0)
    moved = np.concatenate(
        [edges[..., :2] * (1.0 + 0.02 * pushed[..., None]), (edges[..., 2] - pushed)[..., None]], -1
    )
    look = RenderSpec(ground=0.0, dot=255.0)
    plain = render(camera, moved, look).astype(float)
    clutter = np.full(plain.shape, -1.0)
    if rim:
        other = render(camera, moved, look.model_copy(update={"rim": True, "seed": design})).astype(float)
        clutter = np.where(other != plain, other, -1.0)
    return plain / 255.0, clutter


def kernel(length: float, way: float) -> np.ndarray:
    """Kernel of a uniform motion, px."""
    half = int(np.ceil(length / 2.0)) + 1
    grid, y = np.zeros((2 * half + 1,) * 2), 0
    for part in np.linspace(-0.5, 0.5, 201) * length:
        x, y = half + part * np.cos(way), half + part * np.sin(way)
        i, j = int(y), int(x)
        for di, dj in ((0, 0), (0, 1), (1, 0), (1, 1)):
            grid[i + di, j + dj] += (1 - abs(y - i - di)) * (1 - abs(x - j - dj))
    return grid / grid.sum()


def field_of(design: int, offset: tuple[float, float]) -> tuple[np.ndarray, float, float]:
    """Centre of the markers, their rms distance from it, and the median radius of a marker, px."""
    camera, edges = scene(design, offset)
    outline = camera.project(edges)
    centres = outline.mean(axis=1)
    size = float(np.sqrt(((centres - centres.mean(axis=0)) ** 2).sum(axis=1).mean()))
    area = 0.5 * np.abs(
        np.sum(
            outline[..., 0] * np.roll(outline[..., 1], -1, 1) - np.roll(outline[..., 0], -1, 1) * outline[..., 1],
            axis=1,
        )
    )
    return centres.mean(axis=0), size, float(np.median(np.sqrt(area / np.pi)))


def scene_centres(draw: Draw) -> np.ndarray:
    """Centres (m, 2) of the markers that the image shows, px."""
    camera, edges = scene(draw.design, draw.offset)
    centres = camera.project(edges).mean(axis=1)
    size = np.array([camera.width_px, camera.height_px])
    return centres[((centres > 0) & (centres < size - 1)).all(axis=1)].astype(np.float32)


def make(draw: Draw) -> tuple[list[np.ndarray], list[np.ndarray], np.ndarray]:
    """Images at rest, images of a press, and times."""
    rng = np.random.default_rng(draw.seed)
    centre, size, _ = field_of(draw.design, draw.offset)
    shape = covers(draw.design, draw.offset, 0.0, draw.rim)[0].shape
    y, x = np.mgrid[: shape[0], : shape[1]].astype(float)
    way, share = rng.uniform(0, 2 * np.pi), rng.uniform(0, 1)
    across = 0.5 + ((x - centre[0]) * np.cos(way) + (y - centre[1]) * np.sin(way)) / (4.0 * size)
    away = ((x - centre[0]) ** 2 + (y - centre[1]) ** 2) / (2.0 * size) ** 2
    shade = across if share < 0.5 else away
    column, row = scene_centres(draw).T[..., None]
    at_dots = cv2.remap(shade.astype(np.float32), column, row, cv2.INTER_LINEAR)
    shade = np.clip((shade - at_dots.min()) / np.ptp(at_dots), 0.0, 1.2)
    lamps = 1.0 - (1.0 - draw.dimmest) * shade
    tint = rng.uniform(0.75, 1.0, 3) if draw.colour else np.ones(1)
    touched = rng.uniform(-0.2, 0.2)
    rest: list[np.ndarray] = []
    press: list[np.ndarray] = []
    for number in range(REST + (PRESS if draw.press else 0)):
        at, depth = min(number, REST - 1), max(number - REST + 1, 0) * 0.4
        cover, clutter = covers(draw.design, draw.offset, depth, draw.rim)
        dots = cover if not draw.bright else 1.0 - cover
        image = draw.level * lamps * (1.0 - draw.contrast * dots)
        image = np.where(clutter >= 0, 0.5 * clutter, image)
        image = cv2.GaussianBlur(image, (0, 0), draw.edge * draw.blur[at])
        if draw.motion:
            image = cv2.filter2D(image, -1, kernel(draw.motion, rng.uniform(0, np.pi)), borderType=cv2.BORDER_REFLECT)
        zoom = 1.0 + draw.magnified_px[at] / size
        move = np.array([[zoom, 0, 0], [0, zoom, 0]], float)
        move[:, 2] = centre + draw.shift_px[at] - zoom * centre
        if np.abs(move - np.eye(2, 3)).max() > 1e-9:
            image = cv2.warpAffine(image, move, shape[::-1], flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT)
        image = image * draw.light[at]
        if depth:
            image *= draw.press_light ** (depth / (0.4 * PRESS))
            image *= 1.0 + touched * np.exp(-((x - centre[0]) ** 2 + (y - centre[1]) ** 2) / (2 * (0.5 * size) ** 2))
        if draw.clipped:
            image *= 255.0 / np.quantile(image[away < 0.4], 1.0 - draw.clipped)
        image = image[..., None] * tint / tint.max()
        if draw.colour:
            image[..., 2] *= draw.balance[at]
        image = np.full_like(image, draw.covered) if draw.covered else image
        sd = draw.noise * np.sqrt(0.4 + 0.6 * np.clip(image, 0, None) / draw.level)
        image = np.clip(np.rint(image + rng.normal(size=image.shape) * sd), 0, 255).astype(np.uint8)
        into = rest if number < REST else press
        into.append(
            into[-1] if into and rng.uniform() < draw.repeated else image[..., 0] if not draw.colour else image
        )
    return rest, press, draw.times


def good(rng: np.random.Generator, seed: int) -> Draw:
    """Image set without a fault."""
    design, bright = int(rng.integers(len(DESIGNS))), bool(rng.uniform() < 1 / 3)
    draw = Draw(design, seed, bool(rng.uniform() < 0.5), bright, bool(rng.uniform() < 0.5), bool(rng.uniform() < 0.3))
    draw.level, draw.contrast, draw.dimmest = rng.uniform(110, 215), rng.uniform(0.35, 0.8), rng.uniform(0.62, 1.0)
    radius = field_of(design, draw.offset)[2]
    draw.edge, draw.noise = min(rng.uniform(0.5, 1.1), 0.38 * radius), rng.uniform(0.5, 3.0)
    draw.noise = min(draw.noise, sd_of_noise(draw, 0.03))
    draw.shift_px = (
        rng.normal(0, rng.uniform(0, 0.03), (REST, 2)) + np.linspace(0, rng.uniform(0, 0.05), REST)[:, None]
    )
    draw.magnified_px = np.linspace(0, rng.uniform(0, 0.04), REST)
    draw.light = 1.0 + rng.uniform(-1, 1, REST) * rng.uniform(0, 0.006)
    draw.blur = 1.0 + np.linspace(0, rng.uniform(-0.04, 0.04), REST)
    draw.balance = 1.0 + rng.uniform(-1, 1, REST) * rng.uniform(0, 0.006)
    draw.motion = rng.uniform(0, 0.7)
    draw.times = np.arange(REST) / FPS + rng.normal(0, rng.uniform(0, 0.06), REST) / FPS
    return draw


def sd_of_noise(draw: Draw, centre_px: float) -> float:
    """Noise of a pixel, grey levels, whose Cramer-Rao bound of a marker's centre is given, px."""
    edge, radius = np.hypot(draw.edge, 12.0**-0.5), field_of(draw.design, draw.offset)[2]
    return float(centre_px * draw.contrast * draw.level / np.sqrt(4.0 * edge / (np.sqrt(np.pi) * 2.0 * radius)))


def fault(kind: str, strength: float, rng: np.random.Generator, seed: int) -> Draw:
    """Image set with one fault; `strength` is 0 at its weakest and 1 at its strongest."""
    draw, (_, weak, strong) = good(rng, seed), FAULTS[kind]
    value = weak + strength * (strong - weak)
    steps = np.linspace(0.0, 1.0, REST)
    slow = steps if rng.uniform() < 0.5 else 0.5 - 0.5 * np.cos(2 * np.pi * steps)
    sudden = (rng.permutation(REST) < rng.integers(3, REST - 3)).astype(float)
    match kind:
        case "blank":
            draw.covered = value
        case "frozen":
            draw.repeated = value
        case "saturated":
            draw.bright, draw.clipped = False, value
        case "dark":
            draw.level = 255.0 * value
        case "at_border":
            draw.rim, draw.offset = False, cutting_offset(draw.design, round(value), rng)
        case "contrast":
            draw.contrast = value
        case "evenness":
            draw.dimmest = value
        case "focus":
            draw.edge = value * field_of(draw.design, draw.offset)[2]
        case "noise":
            draw.noise = sd_of_noise(draw, value)
        case "motion_blur":
            draw.motion = value
        case "vibration":
            draw.shift_px = rng.normal(0, value, (REST, 2))
        case "drift":
            way = rng.uniform(0, 2 * np.pi)
            draw.shift_px = value * steps[:, None] * [np.cos(way), np.sin(way)]
        case "magnification":
            draw.magnified_px = value * slow
        case "sharpness":
            draw.blur = 1.0 + value * slow
        case "brightness":
            draw.light = 1.0 + rng.choice([-1, 1]) * min(value, 0.3) * (slow if rng.uniform() < 0.5 else sudden)
        case "auto_exposure":
            draw.press, draw.press_light = True, (1.0 + value) ** rng.choice([-1.0, 1.0])
            draw.level = min(draw.level, 250.0 / max(draw.press_light * 1.2, 1.0))
        case "white_balance":
            draw.colour, draw.balance = True, 1.0 - value * (slow if rng.uniform() < 0.5 else sudden)
        case "dropped":
            lost = rng.permutation(np.arange(1, REST + round(value * REST)))[: max(round(value * REST), 1)]
            draw.times = np.delete(np.arange(REST + len(lost)), lost) / FPS + rng.normal(0, 0.03, REST) / FPS
        case "irregular":
            draw.times = np.cumsum(rng.gamma(1.0 / value**2, value**2, REST)) / FPS
    return draw


def cutting_offset(design: int, count: int, rng: np.random.Generator) -> tuple[float, float]:
    """Offset of the camera at which about `count` markers are cut by a border."""
    side, best = rng.integers(2), (99, (0.0, 0.0))
    for offset in rng.choice([-1, 1]) * np.arange(1.0, 25.0, 0.25):
        place = (float(offset), 0.0) if side else (0.0, float(offset))
        camera, edges = scene(design, place)
        pixels = camera.project(edges)
        limit = np.array([camera.width_px, camera.height_px]) - 0.5
        within = ((pixels > -0.5) & (pixels < limit)).all(axis=2).mean(axis=1)
        cut = int(((within > 0.3) & (within < 0.9)).sum())
        if abs(cut - count) < abs(best[0] - count) and cut:
            best = (cut, place)
    return best[1]


def run(kind: str, strength: float, seed: int) -> tuple[list[str], bool]:
    """Findings of one set, and whether the markers were found only with known polarity and diameter."""
    rng = np.random.default_rng([seed, 1])
    draw = good(rng, seed) if kind == "good" else fault(kind, strength, rng, seed)
    sets, hinted = make(draw), False
    found = codes_of(check_camera(*sets))
    if "markers" in found and kind != "blank":
        diameter, hinted = 2.0 * field_of(draw.design, draw.offset)[2], True
        known = DetectSpec(polarity="bright" if draw.bright else "dark", diameter_px=diameter)
        found = codes_of(check_camera(*sets, detect=known))
    return found, hinted


def codes_of(check: CameraCheck) -> list[str]:
    """Codes of the findings, by the names of the kinds."""
    return [one.code.replace("-", "_") for one in check.findings]


def main(sets: str = "11", good_sets: str = "200", out: str = "", seed: str = "0") -> None:
    """Print, and write, one row a kind, then the totals."""
    rows, total = [], Counter[str]()
    for row, kind in enumerate(("good", *FAULTS)):
        many, count, others = int(good_sets) if kind == "good" else int(sets), Counter[str](), Counter[str]()
        for number in range(many):
            found, hinted = run(kind, number / max(many - 1, 1), 10_000 * int(seed) + 500 * row + number)
            count.update(named=kind in found, alone=found == [kind], clean=not found, hinted=hinted)
            others.update(code for code in found if code != kind)
        named, alone = (count["clean"],) * 2 if kind == "good" else (count["named"], count["alone"])
        listed = " ".join(f"{code}:{times}" for code, times in others.items())
        rows.append((kind, *FAULTS.get(kind, ("", "", "")), many, named, alone, count["hinted"], listed))
        print(*rows[-1], sep=" | ", flush=True)
        total.update({f"{kind == 'good'} sets": many, f"{kind == 'good'} right": named})
    print(f"faults named: {total['False right']} of {total['False sets']}")
    print(f"good sets without finding: {total['True right']} of {total['True sets']}")
    if out:
        with Path(out).open("w", newline="") as file:
            file.write(f"# python benchmarks/camera_check.py {sets} {good_sets} {out} {seed}\n")
            head = ("kind", "quantity", "weakest", "strongest", "sets", "right", "alone", "hinted", "other_findings")
            csv.writer(file, lineterminator="\n").writerows([head, *rows])


if __name__ == "__main__":
    main(*sys.argv[1:])
