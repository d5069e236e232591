"""Controllers as folders of C and CasADi text, each law printed once."""
