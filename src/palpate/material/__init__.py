"""Material: cured elastomers as nearly incompressible hyperelastic laws, with the pedigree of their numbers."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
