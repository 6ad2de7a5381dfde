"""The commands of `mbs-ref`: one file each, named after the command, offering `command`, in a folder for each group."""

GROUPS = ("run", "judge", "choose", "explore", "publish", "engines", "maintenance")  # in the order of the help
