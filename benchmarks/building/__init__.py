"""From a description to something callable: time, size, growth."""
