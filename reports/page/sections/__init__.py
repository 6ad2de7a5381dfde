"""The sections of the page: one file each, found by listing this folder."""
