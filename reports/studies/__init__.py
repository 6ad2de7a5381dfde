"""Studies of the full report, a folder each: facts.py declares it, measure.py makes the facts, section.* shows them."""
