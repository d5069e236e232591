"""What runs meet: events, the singular points that carry them, and branches that come close and turn away."""
