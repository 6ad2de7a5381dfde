"""The commands of `mbs-ref`: one file each, named after the command, offering `command`."""
