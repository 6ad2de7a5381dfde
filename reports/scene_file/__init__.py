"""What a scene file may hold: a JSON Schema for editors, and the page docs/scene-file.md."""
