"""What every part of a scene is: its fields, what it is made of, and how parts are checked together."""
