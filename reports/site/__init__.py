"""Pages of the documentation that are generated from the code: the gallery of scenes, what engines can, the truths."""
