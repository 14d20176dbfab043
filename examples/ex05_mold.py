"""Volumes of a contact module and of the mold that casts it."""

from palpate.design import DomeSpec, MountSpec, build_contact_module, build_skin
from palpate.fabrication import ProcessSpec, build_mold


def main() -> float:
    dome, mount, process = build_skin(DomeSpec(height=20, thickness=2)), MountSpec(), ProcessSpec()
    part = build_contact_module(dome, mount).solid()
    scale = 1 / (1 - process.shrinkage_percent / 100)
    mold = build_mold(build_contact_module(dome, mount, scale), process)
    print(f"part {part.volume / 1000:.2f} mL, mold holds {mold.hollow() / 1000:.2f} mL")
    for name, solid in mold.parts.items():
        print(f"{name}: {solid.volume / 1000:.1f} mL of PLA")
    return part.volume / 1000


if __name__ == "__main__":
    main()
