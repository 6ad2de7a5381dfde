"""The vertebral android of the papers, 48 planar bodies, in a crash: stiff."""

from mbs_ref.crash.android import scene_builder

DESCRIPTION = (
    "48 bodies: every vertebra, the ribs and the shoulder of a person, joined by 45 revolutes, seat base and seat back."
)

build = scene_builder("android_vertebral", __doc__, DESCRIPTION)
