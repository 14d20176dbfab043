"""Prints bent as a whole, drawn by formulas of their own: pads stretch, domes sag, cameras stand aside.

Nothing of the package's projection or renderer draws here: the camera is a pinhole written out below, the rest of the
lens a cubic term, the image a supersampled drawing. Only for tests and benchmarks.
"""

from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from needs import needs
from palpate.camera import CameraSpec
from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers, place_orientation_mark
from palpate.vision import build_pattern

DESIGNS = {
    7: (9.0,),
    37: (5.0, 10.0, 15.0),
    61: (4.375, 8.75, 13.125, 17.5),
    91: (3.0, 6.0, 9.0, 12.0, 15.0),
    127: tuple(17.5 * k / 6 for k in range(1, 7)),
    169: (2.5, 5.0, 7.5, 10.0, 12.5, 15.0, 17.5),
}
"""Radii of the rings in mm, as the published designs give them."""
RADIUS = 20.0
"""Of the half sphere that the dots are printed in, mm."""
FOCAL, DISTANCE = 297.5, 48.0


def nominal(points, scale=1.0):
    """Pixels (..., 2) of points (..., 3) from the camera as designed."""
    return FOCAL * scale * points[..., :2] / (points[..., 2:] + DISTANCE) + [200.0 * scale, 150.0 * scale]


def law(count, rng):
    """Factors (k,) on the radii of the rings within 15 %, the rings staying in order, by one of four kinds of law."""
    rho = np.array(DESIGNS[count])
    x = rho / rho.max()
    while True:
        kind = rng.integers(4)
        low, high = rng.uniform(-0.15, 0.15, 2)
        if kind == 0:  # inner rings too small, outer too large, or the reverse
            factor = 1 + low + (high - low) * x ** rng.uniform(0.5, 3)
        elif kind == 1:  # a bump
            factor = 1 + low + (high - low) * np.sin(np.pi * x * rng.uniform(0.5, 1.5)) ** 2
        elif kind == 2:  # every ring by its own
            factor = 1 + rng.uniform(-0.15, 0.15, len(rho))
        else:
            factor = np.full(len(rho), 1 + low)
        gaps = np.diff([0.0, *(factor * rho)]) / np.diff([0.0, *rho])
        if gaps.min() > 0.6 and np.abs(factor - 1).max() <= 0.15 and (factor * rho)[-1] < 19.0:
            return factor


def bent(count, rng, *, scale=1.0, mark=True, missing=0.05, false=10, jitter_px=0.12, turn_deg=0.25, kept=False):
    """Dots of a bent print in pixels; its ellipses take the dots along, or, `kept`, leave them on their rays.

    Returns a dict: dots (n, 2) in random order, truth (m,) the dot of each marker (-1), mark the number of the mark's
    dot or -1, places (m, 2) where each dot is or would be, shape of the image, law (k,), and the pose.
    """
    radii = np.array(DESIGNS[count])
    counts = [6 * k for k in range(1, len(radii) + 1)]
    ring = np.concatenate([[0], *(np.full(n, k + 1) for k, n in enumerate(counts))])
    azimuth = np.concatenate([[0.0], *(2 * np.pi * np.arange(n) / n for n in counts)])
    factor = law(count, rng)
    px = FOCAL * scale / (DISTANCE + 12.0)  # pixels of a millimetre, about
    rho = np.concatenate([[0.0], radii])[ring] * np.concatenate([[1.0], factor])[ring]
    # the mark is printed with the outermost ring: as far outside as designed, stretched as the pad there
    outside = min(radii[-1] + 1.4 * 1.5, (radii[-1] + RADIUS) / 2) - radii[-1]
    stretch = factor[-1] + rng.uniform(-0.1, 0.1)
    edge = radii[-1] * factor[-1]
    rho = np.append(rho, min(edge + outside * stretch, 19.6))
    ring, azimuth = np.append(ring, len(radii)), np.append(azimuth, np.radians(15.0))
    swing = np.radians(np.clip(rng.normal(0, turn_deg, len(rho)), -0.5, 0.5))
    # every dot twice: with its own scatter, and without
    ring, azimuth, rho = np.tile(ring, 2), np.concatenate([azimuth + swing, azimuth]), np.tile(rho, 2)
    x, y = rho * np.cos(azimuth), rho * np.sin(azimuth)
    # ellipse of the whole, and each ring's own
    axis, flat = rng.uniform(0, np.pi), rng.uniform(0, 0.08) / 2
    own_axis = axis + rng.normal(0, 0.3, len(radii) + 1)
    own = flat + rng.uniform(-0.01, 0.01, len(radii) + 1)
    a, f = own_axis[ring], own[ring]
    u, v = np.cos(a) * x + np.sin(a) * y, -np.sin(a) * x + np.cos(a) * y
    if kept:  # flattened, each dot on its ray, as the photographed one is
        angle, length = np.arctan2(v, u), np.hypot(u, v)
        length /= np.hypot(np.cos(angle) / (1 + f), np.sin(angle) / (1 - f))
        u, v = length * np.cos(angle), length * np.sin(angle)
    else:  # stretched
        u, v = u * (1 + f), v * (1 - f)
    x, y = np.cos(a) * u - np.sin(a) * v, np.sin(a) * u + np.cos(a) * v
    # rings off centre by up to 2 px each
    way, far = rng.uniform(0, 2 * np.pi, len(radii) + 1), 2.0 * np.sqrt(rng.random(len(radii) + 1)) / px
    x, y = x + (far * np.cos(way))[ring], y + (far * np.sin(way))[ring]
    z = np.sqrt(np.maximum(RADIUS**2 - x**2 - y**2, 0.0))
    dots, pose = _photographed(np.stack([x, y, z], axis=-1), rng, scale)
    dots, smooth = np.split(dots, 2)
    dots = dots + rng.normal(0, jitter_px, dots.shape)
    gone = np.zeros(len(dots), bool)
    lost = missing * len(dots)
    gone[rng.choice(len(dots), int(lost) + (rng.random() < lost % 1), replace=False)] = True
    if not mark:
        gone[-1] = True
    shape = (round(300 * scale), round(400 * scale))
    middle = np.array(shape[::-1]) / 2 - dots[:-1].mean(axis=0)
    dots, smooth = dots + middle, smooth + middle
    places = dots[:-1].copy()
    seen = np.flatnonzero(~gone)
    extra = _specks(dots[seen], false, shape, 1.5 * px, rng)
    order = rng.permutation(len(seen) + false)
    truth = np.full(len(dots), -1)
    truth[seen] = np.argsort(order)[: len(seen)]
    return {
        "dots": np.vstack([dots[seen], extra])[order],
        "truth": truth[:-1],
        "mark": int(truth[-1]),
        "mark_px": dots[-1],
        "places": places,
        "smooth": smooth[:-1],
        "shape": shape,
        "law": factor,
        "pose": pose,
        "extra": extra,
    }


def _specks(dots, count, shape, apart_px, rng):
    """False dots (count, 2) anywhere, a dot's diameter from what is seen: nearer ones would be one blob with it."""
    found = np.empty((0, 2))
    while len(found) < count:
        new = rng.uniform(0, 1, 2) * np.array(shape[::-1])
        if np.linalg.norm(np.vstack([dots, found]) - new, axis=1).min() > apart_px:
            found = np.vstack([found, new])
    return found


def _photographed(points, rng, scale):
    """Pixels (n, 2) from a camera up to 6 mm beside the axis and 8° tilted, turned by any angle, barrel left over."""
    way, far = rng.uniform(0, 2 * np.pi), 6.0 * np.sqrt(rng.random())
    lean, tilt, roll = rng.uniform(0, 2 * np.pi), np.radians(8.0 * np.sqrt(rng.random())), rng.uniform(0, 2 * np.pi)
    axis = np.array([np.cos(lean), np.sin(lean), 0.0])
    x = points + np.array([far * np.cos(way), far * np.sin(way), DISTANCE])
    x = x * np.cos(tilt) + np.cross(axis, x) * np.sin(tilt) + np.outer(x @ axis, axis) * (1 - np.cos(tilt))
    c, s = np.cos(roll), np.sin(roll)
    plane = (x[:, :2] / x[:, 2:]) @ np.array([[c, s], [-s, c]])
    barrel = rng.uniform(-0.12, 0.03)
    plane = plane * (1 + barrel * (plane**2).sum(axis=1, keepdims=True))
    pose = {"aside_mm": far, "tilt_deg": np.degrees(tilt), "roll_deg": np.degrees(roll), "barrel": barrel}
    return FOCAL * scale * plane, pose


def draw(dots, shape, rng, *, scale=1.0, over=8):
    """A grey picture (h, w) uint8 of dots: black or white, blurred, unevenly lit, noisy, some drawn out to touch."""
    cv2 = needs("cv2")
    h, w = shape
    diameter = rng.uniform(1.1, 1.7) * FOCAL * scale / (DISTANCE + 12.0)
    dark = rng.random() < 0.5
    ground, ink = (200.0, 60.0) if dark else (50.0, 190.0)
    big = np.full((h * over, w * over), 0, np.uint8)
    for x, y in dots:
        axes = 0.5 * diameter * over * np.array([rng.uniform(0.9, 1.1), rng.uniform(0.9, 1.1)])
        centre = (np.array([x, y]) + 0.5) * over - 0.5
        cv2.ellipse(big, tuple(int(v) for v in np.rint(16 * centre)), tuple(int(v) for v in np.rint(16 * axes)),
                    rng.uniform(0, 180), 0, 360, 255, -1, cv2.LINE_8, 4)  # fmt: skip
    cover = cv2.resize(big, (w, h), interpolation=cv2.INTER_AREA).astype(float) / 255.0
    image = ground + (ink - ground) * cover
    image = cv2.GaussianBlur(image, (0, 0), rng.uniform(0.5, 1.2))
    yy, xx = np.mgrid[:h, :w] / max(h, w) - 0.5
    way = rng.uniform(0, 2 * np.pi)
    light = 1 - 0.35 * (xx**2 + yy**2) * 2 + 0.2 * (xx * np.cos(way) + yy * np.sin(way))
    return np.clip(np.rint(image * light + rng.normal(0, 2.0, image.shape)), 0, 255).astype(np.uint8)


class Design(NamedTuple):
    """A published design as the package reads it."""

    pattern: object
    layout: object
    skin: object
    camera: object


@cache
def design_of(count, scale=1.0, marked=False):
    skin = build_skin(DomeSpec(height=20))
    layout = place_markers(skin, MarkerSpec(count=count))
    mark = place_orientation_mark(skin, layout) if marked else None
    pattern = build_pattern(layout.positions, lambda points: nominal(points, scale), mark)
    camera = CameraSpec(
        width_px=round(400 * scale), height_px=round(300 * scale), fx_px=FOCAL * scale, fy_px=FOCAL * scale,
        cx_px=200.0 * scale, cy_px=150.0 * scale, distance=DISTANCE,
    )  # fmt: skip
    return Design(pattern, layout, skin, camera)


class Verdict(NamedTuple):
    """What a naming is worth: of all numberings it gives, the one that is right counts where it says ambiguous."""

    verdict: str
    wrong: int
    lost: int
    stand_ins: int
    naming: object


def judge(naming, drawn, dots, design):
    """Whole, ambiguous (the mark in sight), mark hidden (and said so), lost or wrong.

    Lost is a dot that is said to be missing though it was given.

    A false dot within 0.18 of the distance of neighbours on a ring from an empty place stands in for its dot: it is
    taken for a misprinted one.
    """
    truth, real = drawn["truth"], drawn["dots"]
    out = np.linalg.norm(drawn["smooth"] - drawn["smooth"][1:].mean(axis=0), axis=1)
    same = design.pattern.rings.number[:, None] == design.pattern.rings.number[None]
    near = 0.18 * 2.0 * np.pi * np.array([out[row].mean() for row in same]) / same.sum(axis=1)
    near[0] = near[1]
    there = 0.2 * FOCAL * drawn["shape"][0] / 300.0 / (DISTANCE + 12.0)
    found = []
    for each in (naming, *naming.alternatives):
        have = each.blob >= 0
        off = np.linalg.norm(dots[each.blob] - np.where(truth[:, None] >= 0, real[truth], drawn["places"]), axis=1)
        own = off < (1e-9 if dots is real else there)
        stand_in = have & ~own & (truth < 0) & (off < near)
        wrong = have & ~own & ~stand_in
        given = cKDTree(dots).query(drawn["places"])[0] < (1e-9 if dots is real else there)
        found.append((int(wrong.sum()), int((given & (truth >= 0) & ~have).sum()), int(stand_in.sum()), each))
    marked = design.pattern.marks_px is not None
    wrong, lost, stand_ins, each = min(found, key=lambda one: one[:2]) if naming.ambiguous else found[0]
    if wrong:
        verdict = "wrong"
    elif lost:
        verdict = "lost"
    elif marked and naming.ambiguous:
        verdict = "ambiguous" if drawn["mark"] >= 0 else "mark hidden"
    else:
        verdict = "whole"
    return Verdict(verdict, wrong, lost, stand_ins, replace(each, alternatives=()))


def controls():
    """Kinds of dots that are no print of the design: functions of a generator that give (dots, pattern) pairs."""

    def others(rng):
        for seen, asked in ((37, 91), (91, 37), (127, 169), (169, 127), (7, 37), (37, 7), (91, 169), (169, 91)):
            yield bent(seen, rng, mark=False)["dots"], design_of(asked).pattern

    def random(rng):
        for count in (7, 37, 91, 169):
            yield rng.uniform(0, 1, (count + 10, 2)) * [250, 250], design_of(count).pattern

    def halves(rng):
        for count in (7, 37, 91, 169):
            drawn = bent(count, rng, mark=False, missing=0.0)
            real = rng.permutation(drawn["truth"])[: count // 2]
            false = np.setdiff1d(np.arange(len(drawn["dots"])), drawn["truth"])
            yield drawn["dots"][np.concatenate([real, false])], design_of(count).pattern

    def grids(rng):
        for count in (7, 37, 91, 169):
            side, turn = rng.integers(5, 16), rng.uniform(0, np.pi)
            x, y = np.meshgrid(np.arange(side), np.arange(side))
            if rng.random() < 0.5:
                x, y = x + 0.5 * (y % 2), y * np.sqrt(0.75)
            points = np.stack([x.ravel(), y.ravel()], axis=-1) * 200.0 / side
            points = points @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
            yield points + rng.normal(0, 0.1, points.shape), design_of(count).pattern

    return {"another design": others, "random dots": random, "half of the dots": halves, "a grid of dots": grids}
