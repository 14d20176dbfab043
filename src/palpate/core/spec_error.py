"""Wrong values of a spec in plain sentences: field, value and requirement."""

from __future__ import annotations

from collections.abc import Sequence
from numbers import Real
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails, InitErrorDetails, PydanticCustomError

from palpate.core.errors import PalpateError

if TYPE_CHECKING:
    from pydantic import BaseModel

_REQUIRED = "Input should be "
_BOUNDS = ("greater_than", "greater_than_equal", "less_than", "less_than_equal")


class SpecError(ValidationError, PalpateError):
    """Wrong values given to a spec: pydantic's `ValidationError` with a sentence for each field."""

    @classmethod
    def from_validation(cls, error: ValidationError, spec: type[BaseModel]) -> SpecError:
        """Return the error of a spec that pydantic has raised, with sentences, remedy and code."""
        details = error.errors()
        new = cls.from_exception_data(error.title, [_again(item) for item in details])
        names = [".".join((spec.__name__, *map(str, item["loc"]))) for item in details]
        new.problem = " ".join(f"{describe_value(item, name)}." for item, name in zip(details, names, strict=True))
        fields = [spec.model_fields.get(str(item["loc"][0])) for item in details if item["loc"]]
        helps = dict.fromkeys(field.description for field in fields if field is not None and field.description)
        new.remedy = " ".join(f"Give the {text[:1].lower()}{text[1:]}" for text in helps)
        new.code = details[0]["type"]
        return new

    def __str__(self) -> str:
        """Problem and remedy."""
        return f"{self.problem} {self.remedy}".strip()

    def __reduce__(self) -> tuple[Any, ...]:
        details = [_again(item) for item in self.errors()]
        for item in details:  # other inputs, such as functions, may not be sent to another process
            item["input"] = item["input"] if isinstance(item["input"], str | Real) else repr(item["input"])
        return _rebuild, (self.title, details, self.__dict__)


def describe_value(details: ErrorDetails, name: str, unit: str = "") -> str:
    """State a wrong value and the requirement, e.g. ``"height is -1; it must be at least 2"``."""
    given, head = details["input"], f"{name}: " if name else ""
    message = details["msg"].removeprefix("Value error, ").rstrip(".")
    shown = isinstance(given, str | Real)
    if details["type"] in ("enum", "literal_error"):
        return f"{head}unknown value '{given}'; choose {details['ctx']['expected'].replace(chr(39), '')}"
    if message.startswith(_REQUIRED) and shown and name:
        rule = message.removeprefix(_REQUIRED).partition(", unable")[0]
        rule = rule.replace("greater than or equal to", "at least").replace("less than or equal to", "at most")
        said = "empty" if given == "" else given
        return f"{name} is {said}; it must be {rule}{unit if details['type'] in _BOUNDS else ''}"
    return f"{head}{message}{f' (given {given})' if shown and str(given) not in message else ''}"


def _again(item: ErrorDetails) -> InitErrorDetails:
    """Return an error as pydantic takes it back."""
    kind: Any = item["type"]
    if "url" not in item:  # pydantic documents its own kinds only
        kind = PydanticCustomError(kind, "{palpate}", {**item.get("ctx", {}), "palpate": item["msg"]})
    return InitErrorDetails(type=kind, loc=item["loc"], input=item["input"], ctx=item.get("ctx", {}))


def _rebuild(title: str, details: Sequence[InitErrorDetails], parts: dict[str, Any]) -> SpecError:
    new = SpecError.from_exception_data(title, list(details))
    new.__dict__.update(parts)
    return new
