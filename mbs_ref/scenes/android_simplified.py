"""The simplified android of the papers, 13 planar bodies, in a crash."""

from mbs_ref.crash.android import scene_builder

DESCRIPTION = "13 bodies: 11 parts of a person joined by 10 revolutes, seat base and seat back."

build = scene_builder("android_simplified", __doc__, DESCRIPTION)
