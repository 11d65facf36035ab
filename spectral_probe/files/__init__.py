"""The files the project reads and writes."""
