"""What each function of the contract must be by the Lagrangian, one identity a function; found by themselves."""
