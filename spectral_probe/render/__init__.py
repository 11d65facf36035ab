"""Plans of Cycles passes, passes to tristimulus values, comparison."""
