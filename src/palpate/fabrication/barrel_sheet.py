"""Lines of the workshop sheet for a barrel, for `palpate.fabrication.instructions`."""

from __future__ import annotations

from palpate.design import PRINT_TOLERANCE, MarkerLayout, Skin
from palpate.fabrication.frame import RODS, BarrelFrame
from palpate.fabrication.mold import Mold
from palpate.fabrication.pack import PackContent
from palpate.fabrication.process_sheet import clamping, curing, degassing, mixing, sprues, thickness_tolerance
from palpate.fabrication.spec import ProcessSpec


def describe_barrel(skin: Skin, layout: MarkerLayout, material: str, mold: Mold, spec: ProcessSpec) -> list[str]:
    """Describe the part."""
    return [
        f"{skin.shape}: {skin.height:g} mm between the clamps, inner radius {skin.base_radius:g} mm at both ends and "
        f"{skin.radius:g} mm halfway, T = {skin.thickness:g} mm; a flange at either end.",
        f"{len(layout)} markers of {layout.diameter:g} mm, cast with the skin; they extend {spec.dot_depth:g} mm "
        f"inward. Elastomer: {material}.",
        f"The mold is larger than the part by the shrinkage of the elastomer "
        f"(factor {mold.module.skin.height / skin.height:.5f}).",
        "Angles are those of the part: counter-clockwise from x, seen from its far end (the drawings' apex).",
    ]


def barrel_casting_steps(made: PackContent) -> list[str]:
    """Write the steps from the printed mold to the skin."""
    skin, mold, material = made.module.skin, made.mold, made.design.material.name
    stretch, volume = skin.widest[0] / skin.base_radius, mold.hollow() / 1000
    return [
        "Wash and dry hollow and core; spray them with mold release, the core's dimples too.",
        "Fill every dimple with the pigmented silicone and draw a flexible blade over it, so that it is flush; wipe "
        "the core clean between the dots. Let it cure until it is firm but still tacky: the elastomer bonds to it.",
        "Grease the parting faces thinly, away from the hollow; join the halves of the cavity on their dowels and "
        "tighten the clamps. Stand it on its floor.",
        mixing(material, made.mixed),
        degassing(material),
        f"Pour {volume:.0f} mL into the cavity. Lower the core into it within some 5 min, so that the elastomer "
        "rises around it and drives the air before it, until the spigot is in the floor and the three pins enter: it "
        "fits one way only.",
        "Fill up through the hole until elastomer stands in every vent. " + clamping(mold),
        curing(material),
        sprues(mold.module, made.process),
        "Loosen the clamps, take the halves of the cavity off.",
        "The core is whole. Work soapy water under the flange at its plate and on all around, then push the skin off "
        f"over the far end: its rim stretches {stretch:.3g} times as it passes the middle. A core in segments "
        "would avoid that stretch, but leave a seam along every joint, among the dots.",
        "Wash it. The dots come off with the skin; touch up with the pigmented silicone any that stayed in the core.",
    ]


def barrel_inspection_steps(skin: Skin, layout: MarkerLayout, *, marked: bool) -> list[str]:
    """Write the measurements."""
    return [
        f"Thickness at four places around, halfway and near both ends: {skin.thickness:g} mm, "
        f"± {thickness_tolerance(skin):.2g} mm.",
        f"Distance between the flanges, lying without load: {skin.height:g} mm, "
        f"± {max(0.2, 0.002 * skin.height):.2g} mm.",
        f"All {len(layout)} dots{' and the orientation mark' if marked else ''} present, round to 0.2 mm, separate; "
        f"places within {PRINT_TOLERANCE:g} mm of markers.csv.",
        "No bubble above 0.5 mm; inner surface matt and even.",
    ]


def barrel_assembly_steps(frame: BarrelFrame) -> list[str]:
    """Write the assembly of skin, rods and far end on the housing."""
    high = frame.module.top
    return [
        f"Glue the {RODS} rods into the sockets of the housing, down to their floor. Slide the end cap onto them, so "
        "that they cure parallel; take it off.",
        f"Turn a nut onto each rod until its upper face is {high - frame.module.foot:g} mm above the seat of the "
        "flange, a flat outward.",
        "Draw the skin over the rods and set its flange on the seat, its notch on the key opposite the cable slot: "
        "the rods then stand between columns of dots.",
        "Lay both halves of the clamp ring around the flange and screw them on, crosswise.",
        "Set the end cap onto the nuts, the skin's far flange against it, and a second nut onto each rod. Screw both "
        "halves of the end ring to it, crosswise. Turn the nuts until the skin is neither stretched nor compressed.",
    ]
