"""The method of Pullen & Bregler 2002 on arrays: bands, fragments, matching, paths, joining, texture and synthesis."""
