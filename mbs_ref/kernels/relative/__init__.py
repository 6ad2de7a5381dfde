"""Trees in relative (joint) coordinates: the articulated-body algorithm beside the redundant cores."""
