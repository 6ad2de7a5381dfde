"""An ensemble in parts has the values and the samples of the whole."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbs_ref import scenes
from mbs_ref.settings import Settings
from mbs_ref.simulate.many import ensemble as ensembles
from reports.shared_ensemble import Part, joined

SETTINGS = Settings(t_end=0.1, samples=3)


def test_parts_join_to_the_whole():
    source = ensembles.Source(scenes.make("pendulum"))
    variants = ensembles.Variants(source, [source.target("bob.mass")])
    design = ensembles.design({"bob.mass": ensembles.Uniform(1.0, 2.0)}, 5, seed=3)
    whole = ensembles.run_ensemble(variants, design, SETTINGS, threads=1)
    parts = [Part(design.laws, design.count, design.seed, *ends) for ends in ((0, 2), (2, 5))]
    assert np.array_equal(np.concatenate([part.values for part in parts]), design.values)
    found = joined(design, [ensembles.run_ensemble(variants, part, SETTINGS, threads=1) for part in parts], ((5, 1.0),))
    assert found.is_complete
    assert (found.statuses, found.methods, found.how) == (whole.statuses, whole.methods, whole.how)
    ways = [replace(whole, how=own) for own in (("dop853",), ("dop853", "radau"), ("gauss",))]
    assert joined(design, ways, ()).how == ("dop853", "radau", "gauss")
    for one, other in zip(found.samples, whole.samples, strict=True):
        assert np.array_equal(one, other)
