"""The sections of the page: one file each, listed from this folder."""
