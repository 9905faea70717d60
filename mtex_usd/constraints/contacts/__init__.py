"""Contacts: which points of the feet are planted on the floor, when, and where."""

from mtex_usd.constraints.contacts.detection import Contact, detect_contacts, estimate_ground
from mtex_usd.constraints.contacts.effectors import Effector, body_scale, find_effectors

__all__ = ["Contact", "Effector", "body_scale", "detect_contacts", "estimate_ground", "find_effectors"]
