"""Lengths of world units. Standard library only."""

GLTF = (".glb", ".gltf")

METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9, "angstrom": 1e-10}
"""Length of a unit in metres, the unit of glTF."""


def file_unit(suffix: str, unit: str | None) -> float:
    """World units of the volume times this are the numbers in the file.

    Only glTF fixes a unit. A volume with an unknown unit counts as metres there.
    """
    return METRES.get(unit or "", 1.0) if suffix.lower() in GLTF else 1.0
