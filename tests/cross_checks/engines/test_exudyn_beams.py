"""Exudyn on a beam of segments by its own springs, and its own beam elements beside it."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from mbs_ref import scenes
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from tests.cross_checks.engines.engine_runs import engine
from tests.mbs_ref.scenes.test_beams import bent_rod, modal_lag

END = 1.5  # s


@pytest.mark.slow
def test_exudyns_own_springs_spin_up_the_same_beam():
    scene = scenes.make("spin_up_beam", segments=8)
    times = np.linspace(0.0, END, 16)
    ours = simulate(scene, Settings(method="dop853", rtol=1e-9, estimate="off", reactions=False), times)
    other, errors = engine("exudyn"), []
    for step in (2e-3, 1e-3):
        path = other.run(scene, Settings(method="generalized_alpha", step=step, reactions=False), times)
        assert path.ok, path.message
        assert not any("shared" in note for note in path.notes)
        errors.append(np.abs(path.position - ours.position).max())
    assert errors[1] < 1e-4  # m
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.4)


@pytest.mark.slow
def test_exudyns_beam_elements_lag_as_given_modes():
    """Geometrically exact elements with distributed mass, which segments are compared with by the same modes."""
    exu = pytest.importorskip("exudyn")
    from exudyn import itemInterface as item

    mbs = exu.SystemContainer().AddSystem()
    count, length = 8, 10.0
    nodes = [mbs.AddNode(item.NodeRigidBody2D(referenceCoordinates=[length * k / count, 0.0, 0.0]))
             for k in range(count + 1)]  # fmt: skip
    beam: dict[str, Any] = {"length": length / count, "massPerLength": 1.2, "crossSectionInertia": 6e-4,
                            "bendingStiffness": 1.4e4, "axialStiffness": 2.8e7, "shearStiffness": 1e7}  # fmt: skip
    for pair in pairwise(nodes):
        mbs.AddObject(item.ObjectBeamGeometricallyExact2D(nodeNumbers=list(pair), **beam))
    ground = mbs.AddMarker(item.MarkerNodeCoordinate(nodeNumber=mbs.AddNode(item.NodePointGround()), coordinate=0))

    def angle(t: float) -> float:
        return 0.4 * (0.5 * t * t + (7.5 / np.pi) ** 2 * (np.cos(2.0 * np.pi * t / 15.0) - 1.0))

    def rate(t: float) -> float:
        return 0.4 * (t - 7.5 / np.pi * np.sin(2.0 * np.pi * t / 15.0))

    for coordinate in range(3):
        driven = {"offsetUserFunction": lambda mbs, t, i, x: angle(t),
                  "offsetUserFunction_t": lambda mbs, t, i, x: rate(t)} if coordinate == 2 else {}  # fmt: skip
        root = mbs.AddMarker(item.MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=coordinate))
        mbs.AddObject(item.ObjectConnectorCoordinate(markerNumbers=[ground, root], **driven))
    tip = mbs.AddSensor(
        item.SensorNode(nodeNumber=nodes[-1], outputVariableType=exu.OutputVariableType.Position, storeInternal=True)
    )
    mbs.Assemble()
    options = exu.SimulationSettings()
    options.timeIntegration.endTime, options.timeIntegration.numberOfSteps = 7.0, 1400
    options.solution.file.write = False
    options.solution.sensors.writePeriod, options.timeIntegration.verboseMode = 0.05, 0
    mbs.SolveDynamic(options)
    t, x, y = mbs.GetSensorStoredData(tip)[:, :3].T
    lag = np.cos(angle(t)) * y - np.sin(angle(t)) * x
    assert lag.min() == pytest.approx(modal_lag(t).min(), rel=(lag.min() / length) ** 2)  # a linear theory's own error


@pytest.mark.slow
def test_exudyns_beam_elements_rest_where_the_princeton_beam_does():
    """Elements of order 1 with a Lie group node each, beside our segments and the rod that both tend to."""
    exu = pytest.importorskip("exudyn")
    from exudyn import itemInterface as item

    scene, rod = scenes.make("princeton_beam"), bent_rod(13.345, 45.0)
    rigid = next(load.stiffness for load in scene.loads if load.name == "joint1")  # per pitch of 16 segments
    section, span, errors = exu.BeamSection(), 0.508, []
    section.stiffnessMatrix = np.diag(rigid) * span / 16
    section.massPerLength, section.inertia = 0.1, 1e-6 * np.eye(3)
    for count in (8, 16):
        mbs = exu.SystemContainer().AddSystem()
        places = [[span * k / count, 0.0, 0.0, 0.0, 0.0, 0.0] for k in range(count + 1)]
        nodes = [mbs.AddNode(item.NodeRigidBodyRotVecLG(referenceCoordinates=place)) for place in places]
        for pair in pairwise(nodes):
            beam = item.ObjectBeamGeometricallyExact(nodeNumbers=list(pair), length=span / count, sectionData=section)
            mbs.AddObject(beam)
        ground = mbs.AddMarker(item.MarkerNodeCoordinate(nodeNumber=mbs.AddNode(item.NodePointGround()), coordinate=0))
        for coordinate in range(6):
            root = mbs.AddMarker(item.MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=coordinate))
            mbs.AddObject(item.ObjectConnectorCoordinate(markerNumbers=[ground, root]))
        tip, half = mbs.AddMarker(item.MarkerNodeRigid(nodeNumber=nodes[-1])), 13.345 * np.sqrt(0.5)
        mbs.AddLoad(item.LoadForceVector(markerNumber=tip, loadVector=[0.0, -half, half]))
        mbs.Assemble()
        options = exu.SimulationSettings()
        options.solution.file.write = False
        options.staticSolver.numberOfLoadSteps, options.staticSolver.verboseMode = 10, 0
        mbs.SolveStatic(options)
        errors.append(np.linalg.norm(mbs.GetNodeOutput(nodes[-1], exu.OutputVariableType.Position) - rod))
    assert errors[1] < 2e-4  # m; the tip moves by 0.16
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)
