#!/usr/bin/env python3
"""Exudyn's geometrically exact beam: the bend of 45 degrees (Bathe) of scripts/lab/chart_space.py.

    results/peers/venv/bin/python scripts/lab/peers/exudyn_space.py bend -elements 16

(scripts/lab/peers/setup.sh makes that venv.) Radius and stiffness 1; stretch and shear are those of Bathe's. Static, ten
steps of load. Prints a JSON line of what was found, and one of the cost: processor seconds of the solver. Exit 1: it
failed."""

import json
import sys
import time

import exudyn as exu
import numpy as np
from exudyn.utilities import (Force, MarkerNodeCoordinate, MarkerNodePosition, NodePointGround, NodeRigidBodyEP,
                              ObjectBeamGeometricallyExact, CoordinateConstraint, RotationMatrix2EulerParameters)


def bend(n):
    container = exu.SystemContainer()
    system = container.AddSystem()
    section = exu.BeamSection()
    section.stiffnessMatrix = np.diag([12e4, 6e4, 6e4, 1, 1, 1])
    section.inertia, section.massPerLength = np.diag([1e-3] * 3), 1
    nodes = []
    for a in np.linspace(0, np.pi / 4, n + 1):
        frame = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
        nodes.append(system.AddNode(NodeRigidBodyEP(
            referenceCoordinates=[np.sin(a), 1 - np.cos(a), 0, *RotationMatrix2EulerParameters(frame)])))
    for pair in zip(nodes, nodes[1:]):
        system.AddObject(ObjectBeamGeometricallyExact(nodeNumbers=list(pair), physicsLength=np.pi / 4 / n,
                                                      sectionData=section))
    ground = system.AddMarker(MarkerNodeCoordinate(
        nodeNumber=system.AddNode(NodePointGround()), coordinate=0))
    for c in (0, 1, 2, 4, 5, 6):  # place and the vector part of the quaternion
        system.AddObject(CoordinateConstraint(markerNumbers=[ground, system.AddMarker(
            MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=c))]))
    system.AddLoad(Force(markerNumber=system.AddMarker(MarkerNodePosition(nodeNumber=nodes[-1])),
                         loadVector=[0, 0, 7.2]))
    system.Assemble()
    settings = exu.SimulationSettings()
    settings.staticSolver.numberOfLoadSteps = 10
    settings.staticSolver.verboseMode = 0
    settings.staticSolver.newton.relativeTolerance = 1e-10
    settings.staticSolver.newton.absoluteTolerance = 1e-8
    settings.staticSolver.newton.maxIterations = 50
    settings.solutionSettings.writeSolutionToFile = False
    settings.linearSolverType = exu.LinearSolverType.EigenSparse
    begin = time.process_time()
    system.SolveStatic(settings)
    seconds = time.process_time() - begin
    return np.array(system.GetNodeOutput(nodes[-1], exu.OutputVariableType.Position)), seconds


def main():
    if sys.argv[1] != "bend":
        sys.exit("exudyn_space: bend only")
    tip, seconds = bend(int(sys.argv[sys.argv.index("-elements") + 1]))
    print(json.dumps({"tip": tip.tolist(), "speed": 0.0}))
    print(json.dumps({"seconds": seconds, "steps": 10}))


if __name__ == "__main__":
    main()
