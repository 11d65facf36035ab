"""A shot as a job of a render farm: an Open Job Description bundle, or a list of commands."""
