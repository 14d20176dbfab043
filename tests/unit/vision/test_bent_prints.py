"""Prints bent as a whole are named by their structure; what is no print of the design is refused in a sentence."""

from itertools import islice

import pytest
from bent_prints import bent, controls, design_of, draw, judge

from errors import refused
from palpate.core import generator
from palpate.vision import assign_markers, prepare_detector


@pytest.mark.parametrize("count", [7, 37, 91, 169])
def test_a_bent_print_is_named_wholly_or_says_what_it_does_not_know(count):
    for number in range(8):
        scale, marked = (1.0, 1.6)[number % 2], number % 4 < 2
        drawn = bent(count, generator(8, "bent", count, number), scale=scale, mark=marked, kept=number % 3 == 0)
        design = design_of(count, scale, marked)
        naming = assign_markers(drawn["dots"], design.pattern)
        assert judge(naming, drawn, drawn["dots"], design).verdict in ("whole", "ambiguous", "mark hidden")
        assert marked or naming.ambiguous


@pytest.mark.parametrize("count", [37, 169])
def test_an_image_of_a_bent_print_is_named_through_the_detector(count):
    rng = generator(8, "picture", count)
    drawn = bent(count, rng, scale=1.6, mark=False)
    picture = draw(drawn["dots"], drawn["shape"], rng, scale=1.6)
    dots = prepare_detector(picture).find(picture).positions_px
    design = design_of(count, 1.6)
    assert judge(assign_markers(dots, design.pattern), drawn, dots, design).verdict == "whole"


@pytest.mark.parametrize(("count", "number", "image"), [(37, 37, False), (7, 7, True)])
def test_a_ring_of_six_is_not_bent_to_a_speck(count, number, image):
    """Both were named wrongly without a word: a missing dot replaced by a speck, the mark and a speck in the ring."""
    rng = generator(20, "bent print", count, number, image)
    scale, marked = 1.6 if image else 1.0, bool(number % 2)
    drawn, design = bent(count, rng, scale=scale, mark=marked, kept=True), design_of(count, scale, marked)
    dots = drawn["dots"]
    if image:
        picture = draw(dots, drawn["shape"], rng, scale=scale)
        dots = prepare_detector(picture).find(picture).positions_px
    with refused("assignment-doubtful"):
        assign_markers(dots, design.pattern)


@pytest.mark.parametrize("count", [1, pytest.param(3, marks=pytest.mark.slow)])
@pytest.mark.parametrize("kind", ["another design", "random dots", "half of the dots", "a grid of dots"])
def test_what_is_no_print_of_the_design_is_refused_with_numbers(kind, count):
    for dots, pattern in islice(controls()[kind](generator(8, "controls", kind)), count):
        with refused(("markers-not-assigned", "assignment-doubtful"), len(pattern), len(dots)):
            assign_markers(dots, pattern)
