"""What every stage stands on: parameters, errors, seeds, the artefact store, provenance. No physics."""

from palpate.core.arrays import BoolArray, FloatArray, IntArray, TextArray
from palpate.core.behaviour import stage_version
from palpate.core.errors import MissingExtraError, PalpateError
from palpate.core.extra import load_extra, load_opencv
from palpate.core.files import new_folder, writing, written_into, written_whole
from palpate.core.kernel import kernel
from palpate.core.kinds import spec_of_kind, words_of_kind
from palpate.core.outside_links import refuse_outside_links
from palpate.core.paper import PAPER
from palpate.core.parameter import Spec, flag_of, parameter, parameters
from palpate.core.provenance import installed_version, provenance
from palpate.core.registry import Registry
from palpate.core.renamed import renamed
from palpate.core.seeds import child_seed, generator
from palpate.core.store import ArtefactStore, Recipe, StoreError
from palpate.core.store_care import Stored, check_store, clean_store, list_store
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
    "StoreError",
    "Stored",
    "TextArray",
    "__version__",
    "check_store",
    "child_seed",
    "clean_store",
    "flag_of",
    "generator",
    "installed_version",
    "kernel",
    "list_store",
    "load_extra",
    "load_opencv",
    "new_folder",
    "parameter",
    "parameters",
    "provenance",
    "refuse_outside_links",
    "renamed",
    "spec_of_kind",
    "stage_version",
    "words_of_kind",
    "writing",
    "written_into",
    "written_whole",
]
