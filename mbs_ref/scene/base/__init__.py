"""Common to all parts of a scene: fields, constraint rows, and the checks of parts against each other."""
