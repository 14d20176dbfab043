"""What every stage stands on: parameters, errors, seeds, the artefact store, provenance. No physics."""

from palpate.core.arrays import BoolArray, FloatArray, IntArray, TextArray
from palpate.core.behaviour import stage_version
from palpate.core.errors import MissingExtraError, PalpateError
from palpate.core.external_links import reject_external_links
from palpate.core.extra import load_extra, load_opencv
from palpate.core.files import atomic_folder, atomic_write, atomic_write_into, create_hdf5, wrap_write_errors
from palpate.core.kernel import kernel
from palpate.core.kinds import data_from_text, spec_from_data
from palpate.core.lazy_front import lazy_front
from palpate.core.paper import PAPER
from palpate.core.parameter import Spec, flag_name, parameter, parameters
from palpate.core.provenance import installed_version, provenance
from palpate.core.registry import Registry
from palpate.core.renamed_keys import new_column, rename_columns
from palpate.core.seeds import child_seed, generator
from palpate.core.store import ArtefactStore, Recipe
from palpate.core.store_maintenance import StoreContents, check_store, clean_store, list_store
from palpate.core.version import __version__

__all__ = [
    "PAPER",
    "ArtefactStore",
    "BoolArray",
    "FloatArray",
    "IntArray",
    "MissingExtraError",
    "PalpateError",
    "Recipe",
    "Registry",
    "Spec",
    "StoreContents",
    "TextArray",
    "__version__",
    "atomic_folder",
    "atomic_write",
    "atomic_write_into",
    "check_store",
    "child_seed",
    "clean_store",
    "create_hdf5",
    "data_from_text",
    "flag_name",
    "generator",
    "installed_version",
    "kernel",
    "lazy_front",
    "list_store",
    "load_extra",
    "load_opencv",
    "new_column",
    "parameter",
    "parameters",
    "provenance",
    "reject_external_links",
    "rename_columns",
    "spec_from_data",
    "stage_version",
    "wrap_write_errors",
]
