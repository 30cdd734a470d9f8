"""One run in time: a scene, the method that runs it, its result, and how far off that may be."""
