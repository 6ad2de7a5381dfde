"""Choose an engine, a method and a step."""
