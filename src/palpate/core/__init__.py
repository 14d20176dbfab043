"""What every stage stands on: parameters, errors, seeds, the artefact store, provenance. No physics."""

from palpate.core.errors import MissingExtraError, PalpateError
from palpate.core.extra import load_extra
from palpate.core.kernel import kernel
from palpate.core.outside_links import refuse_outside_links
from palpate.core.parameter import ParameterNote, Spec, flag_of, parameter, parameters
from palpate.core.provenance import installed_version, provenance
from palpate.core.seeds import child_seed, generator
from palpate.core.store import ArtefactStore, Recipe, StoreError
from palpate.core.store_care import Broken, Removal, Stored, check_store, clean_store, list_store

__all__ = [
    "ArtefactStore",
    "Broken",
    "MissingExtraError",
    "PalpateError",
    "ParameterNote",
    "Recipe",
    "Removal",
    "Spec",
    "StoreError",
    "Stored",
    "check_store",
    "child_seed",
    "clean_store",
    "flag_of",
    "generator",
    "installed_version",
    "kernel",
    "list_store",
    "load_extra",
    "parameter",
    "parameters",
    "provenance",
    "refuse_outside_links",
]
