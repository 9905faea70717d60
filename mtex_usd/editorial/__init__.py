"""Editorial: the paths of a shot as an OpenTimelineIO timeline, and edited timelines read back.

A track is a path, a clip is a fragment. A cut is a frame of the shot: the first of the clip after it, and the join that
both fragments share. So the durations of a track's clips add up to the shot's frames, each frame in one clip, and the
fragment behind a clip ends at the first frame of the next one, the last clip's at its own last frame.

A clip's ``source_range`` says where its media begins, in the take's time and rate, and how long the clip is in the
track, as OpenTimelineIO has it; a LinearTimeWarp says how much of the take is played meanwhile.
"""
