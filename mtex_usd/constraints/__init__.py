"""Constraints on motion: retargeting onto other characters, contacts, inverse kinematics, spacetime."""
