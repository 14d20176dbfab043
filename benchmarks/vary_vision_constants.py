"""Half and twice of every numeric constant of detection and assignment: what becomes of drawn images; a page.

python benchmarks/vary_vision_constants.py --out docs/results/sensor/vision_constants.md [--draws 3]
"""

from __future__ import annotations

import argparse
import ast
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "unit" / "vision"))
from bent_prints import bent, design_of, draw, judge
from posed_dome import posed_dots, pressed, project

from drawn_tactip import DrawnSensor, draw_motions, place_heads
from palpate.core import PalpateError, generator
from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.vision import (
    MarkerMatcher,
    MotionModel,
    Tracker,
    assign_markers,
    build_pattern,
    number_markers,
    prepare_detector,
    register_dome,
)

LEGEND = """\
Each constant is halved and doubled alone; a tuple as a whole, a whole number stays at least 1. Prints: bent as a
whole (`tests/unit/vision/bent_prints.py`), 7 to 169 markers. Images: the same through the detector. Free layouts:
rings with jitter, a square grid, a sunflower, in any pose, 10 % missing. Recordings: pins sheared by several
spacings. Presses: markers of a pressed dome, 10 % missing. A drawing counts as right, refused or wrong; of
recordings each image. Constants that change nothing here decide in rarer drawings or only limit time."""
MODULES: dict[str, tuple[str, ...]] = {
    "assign_markers": ("prints",),
    "fit_ring_pattern": ("prints",),
    "find_rings_by_structure": ("prints",),
    "ring_model": ("prints",),
    "ring_seeds": ("prints",),
    "fit_ring": ("prints",),
    "print_distortion": ("poses",),
    "register": ("poses",),
    "detector": ("images",),
    "choose_field": ("images",),
    "segment": ("images",),
    "split": ("images",),
    "fit_free_pattern": ("free layouts",),
    "observed_layout": ("free layouts", "recordings"),
    "motion": ("free layouts", "presses"),
    "match_markers": ("recordings",),
    "tracker": ("presses",),
}
"""Modules with constants, and the drawings that they decide."""


def verdict(good: Callable[..., bool], *given: object) -> str:
    """Whether a drawing is right, refused or wrong."""
    try:
        return "right" if good(*given) else "wrong"
    except (PalpateError, ArithmeticError, ValueError, IndexError):
        return "refused"


def names(drawn, design) -> bool:
    found = judge(assign_markers(drawn["dots"], design.pattern), drawn, drawn["dots"], design)
    return found.verdict in ("whole", "ambiguous", "mark hidden")


def prints(draws: int) -> Iterator[str]:
    """Bent prints named from their dots."""
    for count in (7, 37, 91, 169):
        for number in range(draws):
            drawn = bent(count, generator(30, "vary", count, number), mark=number % 2 == 1, kept=number % 3 == 0)
            design = design_of(count, 1.0, number % 2 == 1)
            yield verdict(names, drawn, design)


def registers(naming, drawn, design) -> bool:
    found = register_dome(naming, design.layout, design.skin, design.camera)
    places = design.layout.positions if found.distortion is None else found.distortion.positions
    off = (found.camera.project(places) - drawn["smooth"])[naming.found]
    return bool(np.sqrt(np.mean((off**2).sum(axis=1))) < 0.5)


def poses(draws: int) -> Iterator[str]:
    """Bent prints registered; right within 0.5 px of the print without each dot's own scatter."""
    for count in (37, 91):
        for number in range(draws):
            drawn, design = bent(count, generator(31, "vary", count, number), mark=False), design_of(count)
            naming = judge(assign_markers(drawn["dots"], design.pattern), drawn, drawn["dots"], design).naming
            yield verdict(registers, naming, drawn, design)


def detects(picture, drawn) -> bool:
    found = prepare_detector(picture).find(picture).positions_px
    dots = drawn["dots"][drawn["truth"][drawn["truth"] >= 0]]
    far = np.linalg.norm(found[:, None] - dots, axis=-1).min(axis=0)
    return bool(np.mean(far < 1.0) > 0.95 and len(found) < 1.05 * len(drawn["dots"]))


def images(draws: int) -> Iterator[str]:
    """Images of bent prints; right if 95 % of the markers are found within 1 px, and few others."""
    for count in (37, 169):
        for number in range(draws):
            rng = generator(32, "vary", count, number)
            drawn = bent(count, rng, scale=1.6, mark=False)
            picture = draw(drawn["dots"], drawn["shape"], rng, scale=1.6)
            yield verdict(detects, picture, drawn)


def assigns(dots, pattern, real, truth) -> bool:
    found = assign_markers(dots, pattern)
    every = [one.blob for one in (found, *found.alternatives)]
    return any(not ((blob >= 0) & real[blob] & (blob != truth)).any() for blob in every)


def free_layouts(draws: int) -> Iterator[str]:
    """Free layouts in any pose."""
    dome = build_skin(DomeSpec(height=20.0))
    x, y = (axis.ravel() * 3.5 for axis in np.meshgrid(np.arange(-5, 6), np.arange(-5, 6)))
    k = np.arange(60)
    planes = [np.stack([x, y], -1), (17 * np.sqrt((k + 0.5) / 60) * np.array([np.cos(2.4 * k), np.sin(2.4 * k)])).T]
    planes = [plane[np.hypot(*plane.T) < 17.5] for plane in planes]
    layouts = [dome.inner_point(np.hypot(*plane.T), np.arctan2(*plane.T[::-1])) for plane in planes]
    for count, jitter in ((37, 0.9), (91, 0.6), (169, 0.5)):
        layouts.append(place_markers(dome, MarkerSpec(count=count)).positions.copy())
        layouts[-1][1:, :2] += generator(0, "free", count).uniform(-jitter, jitter, (count - 1, 2))
    for which, positions in enumerate(layouts):
        pattern, rng = build_pattern(positions, project), generator(33, "vary", which)
        for _ in range(draws):
            dots, truth, _ = posed_dots(positions, len(positions), rng)
            real = np.isin(np.arange(len(dots)), truth[truth >= 0])
            yield verdict(assigns, dots, pattern, real, truth)


def matches(matcher, dots, places, own) -> bool:
    found = matcher.find(dots)
    matcher.remember(dots, found)
    if not found.accepted:
        raise PalpateError(str(found.fault), "", code="image-left")
    off = np.linalg.norm(matcher.layout.rest_px + found.moved_px - places[own], axis=1)
    return bool(np.mean((off < 3) & found.found) > 0.9)


def recordings(draws: int) -> Iterator[str]:
    """Images of sheared pins; right if nine of ten pins have their number."""
    still = np.zeros((4, 2))
    for pattern, rings in (("hexagon", 6), ("square", 9), ("random", 7)):
        sensor, rng = DrawnSensor(rings=rings, pattern=pattern), generator(34, "vary", pattern)
        rest = place_heads(sensor, np.zeros(6), still)[0]
        layout = number_markers(rest)
        matcher = MarkerMatcher(layout, (420, 420))
        own = np.argmin(np.linalg.norm(layout.rest_px[:, None] - rest, axis=-1), axis=1)
        for motion in draw_motions(4 * draws, 1):
            places = place_heads(sensor, motion, still)[0]
            dots = rng.permutation(places + rng.normal(0, 0.1, places.shape))
            yield verdict(matches, matcher, dots, places, own)


def follows(rest, rng) -> bool:
    tracker, tilt, off = Tracker(MotionModel(project(rest))), rng.uniform(-0.2, 0.2), 0.0
    for depth in np.linspace(0.0, 6.0, 10):
        pixels = project(pressed(rest, depth, tilt))
        seen = np.flatnonzero(rng.random(91) > 0.1)
        found = tracker.step(pixels[seen] + rng.normal(0, 0.1, (len(seen), 2)))
        off = max(off, float(np.linalg.norm(found.positions_px - pixels, axis=1).max()))
    return off < 1.0


def presses(draws: int) -> Iterator[str]:
    """Markers of a pressed dome followed; right if each is found or estimated within 1 px."""
    rest = place_markers(build_skin(DomeSpec(height=20.0)), MarkerSpec(count=91)).positions
    for number in range(4 * draws):
        rng = generator(35, "vary", number)
        yield verdict(follows, rest, rng)


SCENES: dict[str, Callable[[int], Iterator[str]]] = {
    "prints": prints,
    "poses": poses,
    "images": images,
    "free layouts": free_layouts,
    "recordings": recordings,
    "presses": presses,
}


def count_verdicts(scenes: tuple[str, ...], draws: int) -> str:
    """Numbers of right, refused and wrong drawings of scenes."""
    found = Counter(one for scene in scenes for one in SCENES[scene](draws))
    return ", ".join(f"{found[name]} {name}" for name in ("right", "refused", "wrong") if found[name])


def scaled(value: object, factor: float) -> object:
    """A constant, or each number of a tuple, times a factor; whole numbers stay whole and at least 1."""
    if isinstance(value, tuple):
        return tuple(scaled(one, factor) for one in value)
    return max(1, round(value * factor)) if isinstance(value, int) else value * factor


@cache
def defined(module: ModuleType) -> frozenset[str]:
    """Names of constants that a module defines itself."""
    nodes = ast.walk(ast.parse(Path(str(module.__file__)).read_text("utf-8")))
    own = (node.id for node in nodes if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store))
    return frozenset(name for name in own if name.upper() == name)


def constants(module: ModuleType) -> Iterator[tuple[str, object]]:
    """Numeric constants that a module defines, and tuples of them."""
    for name, value in vars(module).items():
        numbers = value if type(value) is tuple else (value,)
        if name in defined(module) and all(type(one) in (int, float) for one in numbers):
            yield name, value


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--draws", type=int, default=3)
    given = parser.parse_args()
    command = (__doc__ or "").split("\n\n")[1].strip()
    lines = ["# Constants of detection and assignment", "", f"    {command}", "", LEGEND, ""]
    lines += ["| constant | value | as it is | half | twice |", "| --- | --- | --- | --- | --- |"]
    for name, scenes in MODULES.items():
        module, base = import_module(f"palpate.vision.{name}"), count_verdicts(scenes, given.draws)
        users = [one for key, one in sys.modules.items() if key.startswith("palpate.vision.")]
        for constant, value in list(constants(module)):
            cells = []
            for factor in (0.5, 2.0):
                holders = [one for one in users if one is module or constant not in defined(one)]
                holders = [one for one in holders if vars(one).get(constant) is value]
                for one in holders:
                    setattr(one, constant, scaled(value, factor))
                cells.append(count_verdicts(scenes, given.draws))
                for one in holders:
                    setattr(one, constant, value)
            shown = ["the same" if cell == base else cell for cell in cells]
            lines.append(f"| `{name}.{constant}` | {value} | {base} | {shown[0]} | {shown[1]} |")
            given.out.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
