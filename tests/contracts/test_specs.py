"""What every spec of every stage must satisfy, whoever wrote it."""

import importlib
import inspect
import pickle
import re
from pathlib import Path

import pytest

from errors import refused
from palpate.core import Spec, parameters

SOURCE = Path(__file__).parents[2] / "src" / "palpate"
STAGES = sorted(door.parent.name for door in SOURCE.glob("*/__init__.py"))
REQUIRED = {"Study": {"name": "any"}}


def front_door_specs() -> list[type[Spec]]:
    found = []
    for stage in STAGES:
        door = importlib.import_module(f"palpate.{stage}")
        things = [getattr(door, name) for name in door.__all__]
        found += [thing for thing in things if inspect.isclass(thing) and issubclass(thing, Spec)]
    return sorted(
        {spec for spec in found if spec is not Spec and not inspect.isabstract(spec)}, key=lambda spec: spec.__name__
    )


SPECS = front_door_specs()


def make(spec: type[Spec]) -> Spec:
    return spec.model_validate(REQUIRED.get(spec.__name__, {}))


@pytest.mark.parametrize("spec", SPECS)
def test_defaults_are_within_their_own_bounds(spec: type[Spec]) -> None:
    defaults = {note.name: note.default for note in parameters(spec) if note.default is not None}
    for name, default in defaults.items():
        spec.model_validate({**REQUIRED.get(spec.__name__, {}), name: default})


@pytest.mark.parametrize("spec", SPECS)
def test_a_spec_cannot_be_changed(spec: type[Spec]) -> None:
    name = next(iter(spec.model_fields))
    with refused("frozen_instance"):
        setattr(make(spec), name, getattr(make(spec), name))


@pytest.mark.parametrize("spec", SPECS)
def test_an_unknown_key_is_refused(spec: type[Spec]) -> None:
    with refused("extra_forbidden"):
        spec.model_validate({**REQUIRED.get(spec.__name__, {}), "no_such_key": 1})


@pytest.mark.parametrize("spec", SPECS)
def test_a_spec_survives_json_and_pickle(spec: type[Spec]) -> None:
    made = make(spec)
    assert spec.model_validate_json(made.model_dump_json(exclude_unset=True)) == made
    assert pickle.loads(pickle.dumps(made)) == made


@pytest.mark.parametrize("spec", SPECS)
def test_every_number_declares_unit_and_meaning(spec: type[Spec]) -> None:
    notes = {note.name: note for note in parameters(spec)}
    numbers = [
        name for name, field in spec.model_fields.items() if re.search(r"\b(float|int)\b", str(field.annotation))
    ]
    assert [name for name in numbers if not (notes[name].unit and notes[name].meaning)] == []


@pytest.mark.parametrize("spec", SPECS)
def test_degrees_and_pixels_stand_in_the_name(spec: type[Spec]) -> None:
    marks = {"deg": "_deg", "px": "_px"}
    wrong = [
        note.name for note in parameters(spec) if note.unit in marks and not note.name.endswith(marks[note.unit])
    ]
    assert wrong == []
