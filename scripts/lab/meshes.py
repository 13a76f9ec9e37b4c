"""Surfaces of bodies that are given by their distance, as triangles; by VTK (pip install 'tendril[space]')."""

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk


def surface_at(distance, ranges, spacing):
    """Where distance(x[3, ...]) is 0 within these (from, to) of x1, x2, x3: by flying edges, smoothed; vtkPolyData."""
    axes = [np.arange(a, b, spacing) for a, b in ranges]
    d = distance(np.array(np.meshgrid(*axes, indexing="ij")))
    image = vtk.vtkImageData()
    image.SetDimensions(*d.shape)
    image.SetOrigin(*(a[0] for a in axes))
    image.SetSpacing(spacing, spacing, spacing)
    image.GetPointData().SetScalars(numpy_to_vtk(d.transpose(2, 1, 0).ravel(), deep=True))
    edges, smooth = vtk.vtkFlyingEdges3D(), vtk.vtkWindowedSincPolyDataFilter()
    edges.SetInputData(image)
    edges.SetValue(0, 0)
    smooth.SetInputConnection(edges.GetOutputPort())
    smooth.SetPassBand(0.05)
    smooth.FeatureEdgeSmoothingOff()
    smooth.Update()
    return smooth.GetOutput()


def write_stl(surface, path):
    """Binary."""
    writer = vtk.vtkSTLWriter()
    writer.SetInputData(surface)
    writer.SetFileName(str(path))
    writer.SetFileTypeToBinary()
    writer.Write()
