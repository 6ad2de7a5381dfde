"""Pages of the documentation that are made from the code: the gallery of scenes, what engines can, the truths."""
