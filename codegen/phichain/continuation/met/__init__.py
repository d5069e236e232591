"""What runs meet: events, the singular points that carry them, branches that come close and turn away, and solutions that are known."""
