"""The data of a scene with a stored truth are the same bits on every processor: its truth is found by them."""

import json
import os
import subprocess
import sys

DIGESTS = """
import json
from cross_checks.truths import certificate
from cross_checks.truths.stored_poses import physics_of
from mbs_ref import scenes
print(json.dumps([physics_of(scenes.make(own.scene, **own.parameters)) for own in certificate.every()]))
"""
OLD = {"OPENBLAS_CORETYPE": "Prescott", "NPY_DISABLE_CPU_FEATURES": "X86_V3"}  # neither AVX2 nor fused operations


def test_an_old_processor_makes_the_same_scenes():
    ran = [
        subprocess.Popen([sys.executable, "-c", DIGESTS], env=os.environ | features, stdout=subprocess.PIPE)
        for features in ({}, OLD)
    ]
    here, there = (json.loads(one.communicate(timeout=120)[0]) for one in ran)
    assert len(here) > 20
    assert here == there
