"""FMI 3.0: a scene's variables, their description in XML, and C around its functions."""
