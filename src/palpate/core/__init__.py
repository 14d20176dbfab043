"""Foundations of every stage: parameters, errors, seeds, the artefact store, provenance. No physics."""

from palpate.core.lazy_front import lazy_front

lazy_front(__name__, __file__)
