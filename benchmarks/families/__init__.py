"""Families of limit cycles beside AUTO-07p."""
