"""The twenty points, each a function from the generated folders to what is wrong with them."""
