"""Commands that make and compare whole reports."""
