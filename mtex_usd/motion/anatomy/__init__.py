"""The parts of a humanoid on any skeleton: hips, chest, neck and head, arms, legs and fingers.

Joints are recognised by their names where they follow one of the common conventions, else by the shape of the
hierarchy alone. Retargeting, contacts and inverse kinematics ask for parts and need not know names.
"""

from mtex_usd.motion.anatomy.find import find_anatomy
from mtex_usd.motion.anatomy.parts import PARTS, SIDES, Anatomy

__all__ = ["PARTS", "SIDES", "Anatomy", "find_anatomy"]
