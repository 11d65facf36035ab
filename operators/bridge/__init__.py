"""Arrays to and from Blender data: the only place that knows Cycles."""
