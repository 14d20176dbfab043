"""What every stage stands on: parameters, errors, seeds, the artefact store, provenance. No physics."""

from palpate.core.errors import MissingExtraError, PalpateError
from palpate.core.kernel import kernel
from palpate.core.parameter import Spec, parameter

__all__ = ["MissingExtraError", "PalpateError", "Spec", "kernel", "parameter"]
