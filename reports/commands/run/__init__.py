"""Commands about one scene."""
