"""Random scenes with closed-form event times, and a count of the events that a run misses or invents."""
