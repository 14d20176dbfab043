"""What every stage stands on: parameters, errors, seeds, the artefact store, provenance. No physics."""

from palpate.core.errors import MissingExtraError, PalpateError
from palpate.core.kernel import kernel
from palpate.core.parameter import ParameterNote, Spec, parameter, parameters
from palpate.core.provenance import installed_version, provenance
from palpate.core.seeds import child_seed, generator
from palpate.core.store import ArtefactStore, Recipe

__all__ = [
    "ArtefactStore",
    "MissingExtraError",
    "PalpateError",
    "ParameterNote",
    "Recipe",
    "Spec",
    "child_seed",
    "generator",
    "installed_version",
    "kernel",
    "parameter",
    "parameters",
    "provenance",
]
