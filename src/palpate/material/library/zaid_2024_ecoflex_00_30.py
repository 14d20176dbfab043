"""Ecoflex 00-30 as fitted by Zaid et al. (2024).

Reference: I. M. Zaid et al., *Virtual prototyping of vision-based tactile sensors design for robotic-assisted
precision machining*, Sensors and Actuators A (2024), doi 10.1016/j.sna.2024.115469, Table 2 (printed in Pa).
Five samples each of ASTM D412 tension to stretch 5 and ASTM D395 compression to stretch 0.5. The paper names
no error of the fit.
"""

from palpate.material.law import yeoh
from palpate.material.material import Material

MATERIAL = Material(
    name="zaid_2024_ecoflex_00_30",
    law=yeoh(14115.6e-6, 110.6e-6, 4.8e-6),
    source="Zaid et al. 2024, Table 2, doi 10.1016/j.sna.2024.115469",
    stretch_range=(0.5, 5.0),
)
