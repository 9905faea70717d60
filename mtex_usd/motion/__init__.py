"""Motion as arrays: skeletons, clips, rotations, channels and time. Imports neither USD nor any file format."""
