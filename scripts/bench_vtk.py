#!/usr/bin/env python3
"""From a NIfTI file to a PLY file by VTK's reader, Flying Edges and writer.

A whole command to compare with. It imports nothing but the modules that it needs, and writes binary PLY with normals.
"""

import argparse
import sys

from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D
from vtkmodules.vtkIOImage import vtkNIFTIImageReader
from vtkmodules.vtkIOPLY import vtkPLYWriter


def main() -> int:
    """Reads, extracts, writes."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("volume", help="a NIfTI file")
    parser.add_argument("iso", type=float, help="the value of the surface")
    parser.add_argument("out", help="the PLY file to write")
    arguments = parser.parse_args()
    reader = vtkNIFTIImageReader()
    reader.SetFileName(arguments.volume)
    edges = vtkFlyingEdges3D()
    edges.SetInputConnection(reader.GetOutputPort())
    edges.SetValue(0, arguments.iso)
    edges.ComputeNormalsOn()
    edges.ComputeGradientsOff()
    edges.ComputeScalarsOff()
    writer = vtkPLYWriter()
    writer.SetInputConnection(edges.GetOutputPort())
    writer.SetFileName(arguments.out)
    writer.SetFileTypeToBinary()
    return 0 if writer.Write() else 1


if __name__ == "__main__":
    sys.exit(main())
