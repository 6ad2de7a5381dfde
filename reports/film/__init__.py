"""Pictures of a motion: films, and filmstrips of moments."""
